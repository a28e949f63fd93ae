/// Effect of follower nodes on the cells around them.
#ifndef RSV_FOLLOWER_H
#define RSV_FOLLOWER_H

#include "cluster.h"
#include "curvature.h"

/// Reports the cells around followers whose leaders differ by more than the threshold. @param field with its deviation
void rsv_find_cluster_curvature(const rsv_elements *elements, const rsv_curvature_field *field,
    rsv_curved_edge_found found, void *user);

/// Whether a cell has nodes that follow.
bool rsv_cell_follows(const rsv_elements *elements, uint32_t cell);

/// Metres between the nodes that the values of a cell come from.
float rsv_cell_spacing(const rsv_elements *elements, uint32_t cell);

/// Leaders that halving the radius around a cell would add.
float rsv_cell_new_leaders(const rsv_elements *elements, uint32_t cell);

#endif
