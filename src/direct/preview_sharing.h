/// Shares rays between neighbours: at the edge of a shadow, a node uses the rays of the nodes around it, which together
/// test all points of the source. Applied twice, so that the result of few rays is smooth.
#ifndef RSV_PREVIEW_SHARING_H
#define RSV_PREVIEW_SHARING_H

#include "receiver_blocks.h"

/// A shadow ends at a node: it and its neighbours are to share their rays. Several threads may call it.
void rsv_preview_mark_edge(const rsv_receiver_blocks *blocks, uint32_t node);

/// First `spread` of a block's nodes, from `sums` of all.
void rsv_preview_share(const rsv_receiver_blocks *blocks, const rsv_receiver_block *block);

/// Transmitted fraction of the light of a block's nodes, from `spread` of all.
/// @param irradiance [node_count] in: unoccluded; out: with occlusion
void rsv_preview_shadow(
    const rsv_receiver_blocks *blocks, const rsv_receiver_block *block, rsv_rgb *irradiance);

#endif
