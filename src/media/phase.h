/// Henyey and Greenstein's phase function (1941): the density per solid angle of how far light turns where it is
/// scattered.
#ifndef RSV_PHASE_H
#define RSV_PHASE_H

#include "../core/vec.h"

/// 1/sr; also the density of rsv_phase_sample. @param cos of the angle by which light turns, 1 = it goes straight on
RSV_INLINE float rsv_phase(float g, float cos)
{
    double a = g, spread = fmax(1 + a * a - 2 * a * (double)cos, 1e-300);
    return (float)((1 - a * a) / (4 * M_PI * spread * sqrt(spread)));
}

/// The share of the phase function that is even over all directions: its least value. The rest is positive, too.
RSV_INLINE double rsv_phase_even_share(float g)
{
    double a = fabs((double)g);
    return (1 - a) / ((1 + a) * (1 + a));
}

/// 1/sr; density of the rest. @param g not 0
RSV_INLINE float rsv_phase_uneven(float g, float cos)
{
    double even = rsv_phase_even_share(g);
    return (float)(fmax((double)rsv_phase(g, cos) - even / (4 * M_PI), 0.0) / (1 - even));
}

/// A direction after light that went along `forward` (unit).
RSV_INLINE rsv_vec3 rsv_phase_sample(float g, rsv_vec3 forward, float u1, float u2)
{
    double a = g, cos = 1 - 2 * (double)u1;
    if (fabs(a) > 1e-3) {
        double ratio = (1 - a * a) / (1 + a * cos);
        cos = (1 + a * a - ratio * ratio) / (2 * a);
    }
    cos = fmin(fmax(cos, -1.0), 1.0);
    float sin = (float)sqrt(fmax(1 - cos * cos, 0.0)), phi = 2 * RSV_PI * u2;
    rsv_vec3 t, b;
    v3_frame(forward, &t, &b);
    rsv_vec3 side = v3_mad(v3_scale(t, sin * cosf(phi)), sin * sinf(phi), b);
    return v3_normalize(v3_mad(side, (float)cos, forward));
}

#endif
