/// Lightmaps as KTX 2.0 textures of shared exponents (RGB9E5): four bytes a texel, filtered by hardware, within 0.4 %.
#ifndef RSV_BAKE_KTX2_H
#define RSV_BAKE_KTX2_H

#include "../core/core.h"
#include "resolvent/scene.h"

#define RSV_RGB9E5_MOST 65408.0f ///< the brightest that can be held

/// The code of a colour: nine bits each, red lowest, and five of their exponent. Brighter channels become the
/// brightest.
uint32_t rsv_rgb9e5(rsv_rgb color);

/// @param texel [width * height] row by row from the top
rsv_status rsv_bake_write_ktx2(
    rsv_context *context, const char *path, uint32_t width, uint32_t height, const rsv_rgb *texel);

/// The same of a 3-D texture. @param size along x, y, z; z = 0: a flat one @param texel [z][y][x]
rsv_status rsv_bake_write_ktx2_volume(
    rsv_context *context, const char *path, const uint32_t size[3], const rsv_rgb *texel);

#endif
