/// Groups of nodes that lie close together and look the same way: the coarse level of two-grid solvers.
#ifndef RSV_NODE_GROUPS_H
#define RSV_NODE_GROUPS_H

#include "../elements/elements.h"

/// Hanging nodes are in the group of a parent and do not count where groups are kept equal in size.
/// @param group out [node_count] @param group_count out
rsv_status rsv_group_nodes(const rsv_elements *elements, uint32_t *group, size_t *group_count);

#endif
