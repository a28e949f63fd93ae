/// Rays shared between neighbours: where a shadow ends, a node sees with those of the nodes around it, which between them
/// aim at all places of the source. Twice over, so that what few rays tell is smooth.
#ifndef RSV_PREVIEW_SHARING_H
#define RSV_PREVIEW_SHARING_H

#include "receiver_blocks.h"

/// A shadow ends at a node: it and its neighbours are to share their rays. Several threads may call it.
void rsv_preview_mark_edge(const rsv_receiver_blocks *blocks, uint32_t node);

/// First `spread` of a block's nodes, from `sums` of all.
void rsv_preview_share(const rsv_receiver_blocks *blocks, const rsv_receiver_block *block);

/// Then what is left of the light of a block's nodes, from `spread` of all.
/// @param irradiance [node_count] in: without occlusion; out: behind what stands in its way
void rsv_preview_shadow(
    const rsv_receiver_blocks *blocks, const rsv_receiver_block *block, rsv_rgb *irradiance);

#endif
