/// A material's normalised diffusion profile, one shape per channel; plain C, also for device code.
#ifndef RSV_SCATTER_PROFILE_H
#define RSV_SCATTER_PROFILE_H

#include "normalized_diffusion.h"
#include "resolvent/scene.h"

typedef struct rsv_scatter_profile {
    float d[3]; ///< metres per channel, > 0
} rsv_scatter_profile;

/// Whether light that enters this material leaves it elsewhere.
RSV_INLINE bool rsv_material_scatters_below(const rsv_material *m)
{
    return !m->unlit && !rgb_is_black(m->scatter_distance) && m->metallic < 1 &&
           m->transmission < 1;
}

#define RSV_SHORTEST_SCATTER 1e-12f ///< metres

/// A channel without a mean free path gets one ten-thousandth of the longest, which is as good as none.
RSV_INLINE rsv_scatter_profile rsv_scatter_profile_of(const rsv_material *m)
{
    float shortest = f_max(1e-4f * rgb_max(m->scatter_distance), RSV_SHORTEST_SCATTER);
    rsv_scatter_profile profile;
    profile.d[0] =
        f_max(m->scatter_distance.r, shortest) / (float)rsv_diffuse_surface_scale(m->base_color.r);
    profile.d[1] =
        f_max(m->scatter_distance.g, shortest) / (float)rsv_diffuse_surface_scale(m->base_color.g);
    profile.d[2] =
        f_max(m->scatter_distance.b, shortest) / (float)rsv_diffuse_surface_scale(m->base_color.b);
    return profile;
}

RSV_INLINE float rsv_scatter_profile_widest(const rsv_scatter_profile *p)
{
    return f_max(p->d[0], f_max(p->d[1], p->d[2]));
}
RSV_INLINE float rsv_scatter_profile_narrowest(const rsv_scatter_profile *p)
{
    return f_min(p->d[0], f_min(p->d[1], p->d[2]));
}

/// exp(x) for x <= 0 to 2e-7, in arithmetic that compilers turn into vector code.
RSV_INLINE float rsv_exp_negative(float x)
{
    float y = f_max(x * 1.44269504f, -126.0f), whole = floorf(y), f = y - whole;
    // 2^f on [0, 1), least squares in relative error
    float power =
        1.0f +
        f * (0.69315308f +
                f * (0.24015361f + f * (0.055826318f + f * (0.0089893397f + f * 0.0018775767f))));
    union {
        int32_t bits;
        float value;
    } scale = { ((int32_t)whole + 127) * (1 << 23) };
    return power * scale.value;
}

/// log(x) for finite x >= 1, with an absolute or relative error of 1e-7, whichever is larger.
RSV_INLINE float rsv_log_above_one(float x)
{
    union {
        float value;
        int32_t bits;
    } all = { x }, part;
    // x = 2^exponent part, with part in [sqrt(1/2), sqrt(2))
    int32_t exponent = (all.bits - 0x3f3504f3) >> 23;
    part.bits = all.bits - exponent * (1 << 23);
    float t = (part.value - 1) / (part.value + 1), t2 = t * t;
    float series = 2 + t2 * (2.0f / 3 + t2 * (2.0f / 5 + t2 * (2.0f / 7 + t2 * (2.0f / 9))));
    return (float)exponent * 0.693147181f + t * series;
}

#endif
