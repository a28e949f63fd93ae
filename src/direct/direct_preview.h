/// Direct light of a moving source: like rsv_direct_irradiance, with stored receivers and few rays.
///
/// All receivers use the same sixteen points of a source, with one ray from each of their four points, so that the
/// edges of shadows are smooth, if slightly displaced. Sixteen neighbours first trace one ray each, to different
/// points. If all agree, that is the result. If a block of four does not agree, a node takes its visibility from the
/// rays of all nodes around it. Unoccluded irradiance is that of Lambert's formula here too.
#ifndef RSV_DIRECT_PREVIEW_H
#define RSV_DIRECT_PREVIEW_H

#include "receiver_blocks.h"

/// Whether a preview finds all direct light of a source: that of punctual lights and of emitters whose sides are equal,
/// but not of environments.
bool rsv_can_preview(const rsv_lights *lights);

/// Irradiance of the nodes in blocks, and 0 for those that receive nothing or hang, whose values the caller
/// interpolates. Other nodes are unchanged. Nodes lit only by a sliver of a source, beyond all of its points, are dark.
/// @param irradiance [node_count]
rsv_status rsv_direct_preview(const rsv_receiver_blocks *blocks, const rsv_lights *lights,
    rsv_rgb *irradiance, uint64_t *rays);

#endif
