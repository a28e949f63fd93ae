/// The origins of light that leaves a translucent body: the cells of its surface in a tree, so that distant ones count
/// as clusters (after Jensen and Buhler 2002).
///
/// A *body* is the faces of one object, material and side. The fraction of the light entering at y that leaves at x is
///
///     k(x, y) = p(|x - y|) / max(1, N(x), N(y)),   N(x) = int p(|x - y|) dA(y) over the body
///
/// per area: the normalised diffusion profile over the straight distance. On a large flat body, N is 1. At thin parts
/// and edges, N is above 1, and these would receive more light than there is. The divisor keeps the light that a point
/// receives and sends at most 1, and k symmetric.
#ifndef RSV_SCATTER_SOURCES_H
#define RSV_SCATTER_SOURCES_H

#include "../elements/elements.h"
#include "../subsurface/scatter_profile.h"

typedef struct rsv_scatter_body {
    rsv_scatter_profile profile;
    uint32_t first_cell, cell_count; ///< in the order of the tree
    uint32_t root;
    double area; ///< m2
} rsv_scatter_body;

/// A ball of cells.
typedef struct rsv_scatter_cluster {
    rsv_vec3 centre;
    rsv_vec3 normal; ///< area-weighted mean, shorter than 1 where the surface bends
    float radius, area;
    float spread; ///< mean square distance from the centre, m2
    uint32_t first_cell, cell_count;
    uint32_t right; ///< the left child follows its parent; 0 = leaf
} rsv_scatter_cluster;

typedef struct rsv_scatter_sources {
    rsv_context *context;
    const rsv_elements *elements;
    size_t body_count, cell_count, cluster_count;
    rsv_scatter_body *body;       ///< [body_count]
    uint32_t *face_body;          ///< [face_count] RSV_NONE = light leaves where it entered
    uint32_t *cell;               ///< [cell_count] cells of the elements, body by body
    rsv_vec3 (*corner)[3];        ///< [cell_count] of those
    rsv_scatter_cluster *cluster; ///< [cluster_count] parents before children
} rsv_scatter_sources;

/// @param sources out; NULL if the scene has no such material
rsv_status rsv_scatter_sources_create(const rsv_elements *elements, rsv_scatter_sources **sources);
void rsv_scatter_sources_destroy(rsv_scatter_sources *sources);

/// The body that a node lies on, or RSV_NONE.
uint32_t rsv_scatter_body_of(const rsv_scatter_sources *sources, uint32_t node);

/// Appends each cluster's area-weighted mean to a field.
/// @param value [node_count + cluster_count], hanging nodes constrained
void rsv_scatter_collect(const rsv_scatter_sources *sources, rsv_rgb *value);

/// The transposed of that: hands weights on clusters to the nodes of their cells.
/// @param weight [node_count + cluster_count]; those of clusters are used up
void rsv_scatter_collect_transpose(const rsv_scatter_sources *sources, rsv_rgb *weight);

/// A corner of a cell of the elements, and the centre of three corners.
rsv_vec3 rsv_scatter_corner(const rsv_elements *elements, uint32_t cell, int k);
rsv_vec3 rsv_scatter_centroid(const rsv_vec3 corner[3]);

#endif
