/// Directions towards those parts of the sky that are seen and a rough surface reflects: a mixture of squares of the
/// octahedral map, with its exact density.
#ifndef RSV_SKY_AIM_H
#define RSV_SKY_AIM_H

#include "sky_visibility.h"

typedef struct rsv_sky_aim {
    const rsv_sky_square *square; ///< borrowed
    uint32_t count;               ///< 0 = nothing to aim at
    uint16_t choice[RSV_MOST_VISIBLE_SQUARES];
    float chance[RSV_MOST_VISIBLE_SQUARES]; ///< of each; they add up to 1
} rsv_sky_aim;

/// Weights the visible sky by its brightness and, approximately, the surface's response.
/// @param visible from rsv_sky_visibility_at, NULL = none
/// @param wo, normal as in bsdf.h
void rsv_sky_aim_at(const rsv_sky_visibility *visibility, const rsv_visible_sky *visible,
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 normal, rsv_sky_aim *aim);

/// A direction. @param aim not empty @param u for the choice and for the place, in [0, 1)
rsv_vec3 rsv_sky_aim_sample(const rsv_sky_aim *aim, const float u[3]);

/// Its density per solid angle.
float rsv_sky_aim_pdf(const rsv_sky_aim *aim, rsv_vec3 direction);

#endif
