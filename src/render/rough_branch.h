/// The one branch that a rough surface on the way of a camera ray sends on. Plain C, also for device code.
#ifndef RSV_ROUGH_BRANCH_H
#define RSV_ROUGH_BRANCH_H

#include "branch.h"
#include "rough_light.h"

/// What a rough surface draws.
typedef struct rsv_rough_numbers {
    float kept, light[3], direction[3], sky[3];
} rsv_rough_numbers;

/// @param path as in camera_chain.h
RSV_INLINE rsv_rough_numbers rsv_rough_numbers_of(uint32_t path, uint32_t triangle)
{
    rsv_rough_numbers n;
    rsv_random random = rsv_random_from(path, triangle, 0x17c3u);
    n.kept = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.light[k] = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.direction[k] = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.sky[k] = rsv_random_float(&random);
    return n;
}

/// Rough lobes are looked at as often as they are this many times the diffuse one's share.
#define RSV_ROUGH_WORTH 10

/// Chance of looking at rough lobes: wide ones that are faint beside the diffuse one, to the eye, are not worth two rays
/// each time.
RSV_INLINE float rsv_rough_chance(
    const rsv_rough_surface *surface, const rsv_bsdf_branches *branches)
{
    const rsv_bsdf *bsdf = surface->bsdf;
    if (!rsv_rough_is_wide(bsdf)) return 1;
    float rough = rsv_bsdf_specular_chance(bsdf, surface->wo, surface->normal, surface->front);
    float diffuse = rgb_luminance(rgb_mul(branches->diffuse, bsdf->base_color));
    return RSV_ROUGH_WORTH * rough < diffuse ? RSV_ROUGH_WORTH * rough / diffuse : 1;
}

/// Whether an event of rsv_rough_draw sends the chain on.
RSV_INLINE bool rsv_rough_goes_on(const rsv_bsdf_event *event)
{
    bool specular = event->lobe == RSV_LOBE_REFLECT || event->lobe == RSV_LOBE_TRANSMIT;
    return specular && event->pdf_solid_angle > 0;
}

#endif
