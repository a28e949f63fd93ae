/// One row of subsurface scattering: which share of the light that enters each place leaves at one node.
#ifndef RSV_SCATTER_ROW_H
#define RSV_SCATTER_ROW_H

#include "scatter_sources.h"

/// A short list of nodes and clusters, and the memory to make it in.
typedef struct rsv_scatter_row {
    rsv_context *context;
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
