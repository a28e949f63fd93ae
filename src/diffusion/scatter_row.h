/// One row of subsurface scattering: which share of the light that enters each place leaves at one node.
#ifndef RSV_SCATTER_ROW_H
#define RSV_SCATTER_ROW_H

#include "scatter_sources.h"

#define RSV_SCATTER_PATCHES 32

/// Pieces of surface over which the profile is not integrated yet: cells and clusters that are small against their
/// distance.
typedef struct rsv_scatter_patches {
    uint32_t count;
    float x[RSV_SCATTER_PATCHES], y[RSV_SCATTER_PATCHES],
        z[RSV_SCATTER_PATCHES]; ///< centre, relative to the place
    float nx[RSV_SCATTER_PATCHES], ny[RSV_SCATTER_PATCHES],
        nz[RSV_SCATTER_PATCHES];       ///< normal of the surface, at most 1 long
    float spread[RSV_SCATTER_PATCHES]; ///< mean square distance from the centre, m2
    float area[RSV_SCATTER_PATCHES];
    float mean[3][RSV_SCATTER_PATCHES];        ///< of the profile, per channel
    const uint32_t *node[RSV_SCATTER_PATCHES]; ///< of a cell; NULL = a cluster
    uint32_t column[RSV_SCATTER_PATCHES];      ///< of a cluster
} rsv_scatter_patches;

/// A short list of nodes and clusters, and the memory to make it in.
typedef struct rsv_scatter_row {
    rsv_context *context;
    rsv_scatter_patches patches;
    uint32_t count;
    uint32_t *column; ///< [count] a node, or node_count + a cluster
    rsv_rgb *weight;  ///< [node_count + cluster_count] by column; only listed ones mean anything
    uint8_t *listed;  ///< [node_count + cluster_count]
} rsv_scatter_row;

rsv_status rsv_scatter_row_create(const rsv_scatter_sources *sources, rsv_scatter_row *row);
void rsv_scatter_row_destroy(rsv_scatter_row *row);

/// Integrates p(|x - y|) times the hats over the body of `node`, which must lie on one, with x the node: the share
/// before it is divided by N.
void rsv_scatter_gather(const rsv_scatter_sources *sources, uint32_t node, rsv_scatter_row *row);

#endif
