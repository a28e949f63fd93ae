/// Meshes finer than the wanted spacing: most of their vertices need no row of their own.
#ifndef RSV_CLUSTER_H
#define RSV_CLUSTER_H

#include "bend.h"

/// Keeps some nodes of finely meshed surfaces as leaders and lets the others follow: a follower's value is a smooth
/// weighted mean of the leaders around it, so the field stays continuous and shows no facets.
///
/// Distance runs along the edges of cells, so that it leads neither across creases and walls nor through thin
/// bodies, and a turn of the surface counts like a way: a small ball keeps leaders on all sides. Only nodes whose
/// cells are whole triangles follow; grids and split cells have the size that somebody asked for.
/// @param radius metres, halved `face_halvings` times: every follower has a leader within it, and is led by those within
/// twice of it
rsv_status rsv_elements_cluster(rsv_elements *elements, float radius);

/// Reports the cells around followers whose leaders differ by more than `threshold` of the local level plus `floor`.
/// @param value [node_count] @param deviation [node_count] noise of its luminance
void rsv_find_cluster_bends(const rsv_elements *elements, const rsv_rgb *value,
    const float *deviation, float threshold, float floor, rsv_bend_found found, void *user);

/// Whether a cell has nodes that follow.
bool rsv_cell_follows(const rsv_elements *elements, uint32_t cell);

/// Metres between the nodes that the values of a cell come from.
float rsv_cell_spacing(const rsv_elements *elements, uint32_t cell);

/// Leaders that halving the radius around a cell would add.
float rsv_cell_new_leaders(const rsv_elements *elements, uint32_t cell);

#endif
