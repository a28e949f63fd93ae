/// Normalised diffusion (Christensen and Burley 2015, "Approximate reflectance profiles for efficient subsurface
/// scattering"): the distance between where light enters and leaves. Plain C, also for device code.
///
///     p(r) = (exp(-r / d) + exp(-r / (3 d))) / (8 pi d r),   int_0^inf 2 pi r p dr = 1
///
/// times the total reflectance A is the searchlight response R(r) of a half space. The shape d = l / s(A) follows from
/// the mean free path l by one of the paper's fits s.
#ifndef RSV_NORMALIZED_DIFFUSION_H
#define RSV_NORMALIZED_DIFFUSION_H

#include "../core/vec.h"

/// s for a searchlight at normal incidence; l is the volume's mean free path.
RSV_INLINE double rsv_searchlight_scale(double albedo)
{
    double x = fabs(albedo - 0.8);
    return 1.85 - albedo + 7 * x * x * x;
}
/// s for light that enters diffusely: irradiance from many directions, as elements receive it.
RSV_INLINE double rsv_diffuse_surface_scale(double albedo)
{
    double x = albedo - 0.8;
    return 1.9 - albedo + 3.5 * x * x;
}
/// s where l is the diffuse mean free path at the surface.
RSV_INLINE double rsv_diffuse_path_scale(double albedo)
{
    double x = albedo - 0.33;
    return 3.5 + 100 * (x * x) * (x * x);
}

/// p(r), 1/m2. @param d shape, metres, > 0 @param r metres, > 0
RSV_INLINE double rsv_diffusion_profile(double d, double r)
{
    double wide = exp(-r / (3 * d));
    return (wide * wide * wide + wide) / (8 * 3.14159265358979323846 * d * r);
}

/// Share of the light that leaves within r of where it entered.
RSV_INLINE double rsv_diffusion_cdf(double d, double r)
{
    return -0.25 * expm1(-r / d) - 0.75 * expm1(-r / (3 * d));
}

/// Inverse of rsv_diffusion_cdf in closed form: t = exp(-r / (3 d)) solves t^3 + 3 t = 4 (1 - u), which
/// 2 sinh(x / 3) does with sinh x = 2 (1 - u). @param u in [0, 1)
RSV_INLINE double rsv_diffusion_sample_radius(double d, double u)
{
    double t = 2 * sinh(asinh(2 * (1 - u)) / 3);
    return -3 * d * log(t < 1 ? t : 1);
}

/// Transfer function of p at `wave_number` (rad/m): its two-dimensional Fourier transform.
RSV_INLINE double rsv_diffusion_transfer(double d, double wave_number)
{
    double x = wave_number * d;
    return 0.25 / sqrt(1 + x * x) + 0.75 / sqrt(1 + 9 * x * x);
}

#endif
