/// Indirect light where elements do not show it well: in narrow places, in corners, and wherever it changes much within one element.
/// There it is gathered once more at the value itself.
#ifndef RSV_BAKE_MEND_H
#define RSV_BAKE_MEND_H

#include "bake_patch.h"

/// What is to be added to a patch's light, W/m2.
/// @param light borrowed; what elements store of it is read as the bake read it
/// @param total luminance of the patch as it is, W/m2; no less than what counts as dark
rsv_rgb rsv_bake_mend(
    const rsv_light_view *light, const rsv_bake_patch *patch, float total, uint32_t seed);

#endif
