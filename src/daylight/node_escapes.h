/// Rays of elements that reach the sky: the source term of each patch.
#ifndef RSV_NODE_ESCAPES_H
#define RSV_NODE_ESCAPES_H

#include "daylight.h"

typedef struct rsv_node_escape {
    uint32_t node, patch, group;
    rsv_rgb irradiance; ///< of the node in that group, by radiance of the patch
} rsv_node_escape;

typedef struct rsv_node_escapes {
    rsv_node_escape *escape; ///< [count] in the order of nodes
    size_t count;
} rsv_node_escapes;

rsv_status rsv_node_escapes_find(const rsv_daylight *daylight, rsv_node_escapes *escapes);
void rsv_node_escapes_free(rsv_context *context, rsv_node_escapes *escapes);

#endif
