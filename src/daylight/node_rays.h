/// Rays of elements, block by block.
#ifndef RSV_NODE_RAYS_H
#define RSV_NODE_RAYS_H

#include "../solve/operator.h"
#include "node_escapes.h"

#define RSV_NODE_PACKET RSV_SUPPORT_POINTS ///< rays of a packet

/// Results of the rays of a block of nodes.
typedef struct rsv_block_escapes {
    rsv_node_escape *escape;
    size_t count, capacity;
    rsv_status status;
} rsv_block_escapes;

typedef struct rsv_node_job {
    const rsv_daylight *daylight;
    const rsv_operator_view *op;
    uint32_t packets; ///< per group
} rsv_node_job;

/// Appends, unless something failed before.
void rsv_block_escapes_add(
    rsv_context *context, rsv_block_escapes *block, const rsv_node_escape *escape);

/// Rays of the nodes from `begin` to `end`.
void rsv_node_rays_trace(
    const rsv_node_job *job, size_t begin, size_t end, rsv_block_escapes *found);

#endif
