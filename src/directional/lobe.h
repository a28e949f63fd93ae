/// A GGX lobe as weights on a map: a spot around the mirrored direction and a share of the mean of all.
///
/// Lobes of D G cos have a narrow middle and long tails. tests/unit/test_directional.c measures what such pairs err
/// beside lobes that are traced in a small room: .12 RMS at a roughness of .3, .07 at .7. At 1 the lobe is the mean.
#ifndef RSV_LOBE_H
#define RSV_LOBE_H

#include "../core/vec.h"

/// Of the spot: 0 = as fine as cells are, 1 = twice as wide ...
RSV_INLINE float rsv_lobe_level(float roughness)
{
    return f_min(f_max(3.4f * roughness - 0.92f, 0), 2);
}

/// Share of the mean.
RSV_INLINE float rsv_lobe_tails(float roughness)
{
    return f_min(f_max(0.53f * (roughness + roughness * roughness) - 0.06f, 0), 1);
}

/// Share of the spot above the surface, which a bent normal may send below: 1 where it is not bent.
/// @param height, own cosines of the mirrored direction with the surface's normal and with the lobe's
RSV_INLINE float rsv_lobe_above(float height, float own, float alpha)
{
    float scale = 0.5f / (alpha + 0.05f);
    float above = f_min(f_max(0.5f + scale * height, 0), 1);
    return f_min(above / f_min(0.5f + scale * f_max(own, 0), 1), 1);
}

#endif
