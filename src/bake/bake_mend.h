/// Indirect light where elements are not accurate: in narrow places, in corners, and wherever it varies strongly within
/// one element. It is gathered there again for each value.
#ifndef RSV_BAKE_MEND_H
#define RSV_BAKE_MEND_H

#include "bake_patch.h"

/// Correction of a patch's light, W/m2.
/// @param light borrowed; stored light is read in the same way as by the bake
/// @param total luminance of the patch at present, W/m2; at least that of dark places
rsv_rgb rsv_bake_mend(
    const rsv_light_view *light, const rsv_bake_patch *patch, float total, uint32_t seed);

#endif
