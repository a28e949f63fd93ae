/// Direct light of a source on the move: as rsv_direct_irradiance, from receivers that are kept, with few rays.
///
/// All receivers aim at the same sixteen places of a source, a ray from each of their four points, so that the edges of
/// shadows come out smooth, if off by what a few places tell. Sixteen neighbours send one ray each first, to as many
/// places: where all see the same, that is that. Where a block of four of them does not, a node takes its share of the
/// light from the rays of all nodes around it. Without occlusion irradiance is that of Lambert's formula, here too.
#ifndef RSV_DIRECT_PREVIEW_H
#define RSV_DIRECT_PREVIEW_H

#include "receiver_blocks.h"

/// Whether a preview finds all of a source's direct light: of punctual lights and of emitters whose sides are alike,
/// not of surroundings.
bool rsv_can_preview(const rsv_lights *lights);

/// Irradiance of the nodes in blocks, and 0 for those that receive nothing or hang: those are to be constrained. The others
/// are left as they are. What only a sliver of a source lights, past all of its places, is dark.
/// @param irradiance [node_count]
rsv_status rsv_direct_preview(const rsv_receiver_blocks *blocks, const rsv_lights *lights,
    rsv_rgb *irradiance, uint64_t *rays);

#endif
