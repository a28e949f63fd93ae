/// Reflectance of an interface under a thin film, per channel; plain C, also for device code.
///
/// With a and b the amplitude reflectances of the film's two faces and D = 2 n d cos the path that a round trip in it
/// adds, Airy's formula is a geometric series in cosines of that path,
///
///     1 - R = (1 - a^2) (1 - b^2) / (1 + a^2 b^2 + 2 a b cos(2 pi D / lambda))
///           = (1 - a^2) (1 - b^2) / (1 - a^2 b^2) (1 + 2 sum_m (-a b)^m cos(2 pi m D / lambda)),
///
/// so its mean over a channel's sensitivity requires only that channel's mean cosine, which is tabulated (as Belcour
/// and Barla 2017 do for the sensitivities of the eye). Channels are those of linear sRGB under equal-energy light,
/// scaled so that white is (1, 1, 1). Values outside their gamut are clamped.
#ifndef RSV_THIN_FILM_H
#define RSV_THIN_FILM_H

#include "tables.h"

typedef struct rsv_thin_film {
    float share;     ///< fraction of the surface that has it; 0 = none
    float ior;       ///< >= 1
    float thickness; ///< micrometres
} rsv_thin_film;

/// Most terms of the series: few are needed but at grazing angles, where the factor before the sum is small.
#define RSV_FILM_TERMS 64

/// Mean cosine of a path that is `path` micrometres longer, per channel.
RSV_INLINE rsv_rgb rsv_film_cosine(const rsv_bsdf_tables *tables, float path)
{
    float x = path * RSV_FILM_STEPS_PER_UM;
    if (!(x < RSV_FILM_STEPS - 1)) return rgb_gray(0);
    int k = (int)x;
    float weight = x - (float)k;
    const float *a = tables->film_cosine[k], *b = tables->film_cosine[k + 1];
    return rgb(a[0] + weight * (b[0] - a[0]), a[1] + weight * (b[1] - a[1]),
        a[2] + weight * (b[2] - a[2]));
}

/// 1 - R of one polarisation. @param a, b amplitude reflectances @param path D, micrometres
RSV_INLINE rsv_rgb rsv_film_transmittance(
    const rsv_bsdf_tables *tables, float a, float b, float path)
{
    float q = -a * b, power = (1 - a * a) * (1 - b * b) / f_max(1 - q * q, 1e-6f);
    rsv_rgb sum = rgb_gray(power);
    RSV_ROLLED
    for (int m = 1; m <= RSV_FILM_TERMS; m++) {
        power *= q;
        if (!((float)m * path < RSV_FILM_MOST_PATH) || fabsf(power) < 1e-5f) break;
        sum = rgb_mad(sum, 2 * power, rsv_film_cosine(tables, (float)m * path));
    }
    return sum;
}

/// Unpolarised reflectance from outside at cosine `cos`. @param base ior below the film, >= 1
RSV_LARGE rsv_rgb rsv_film_reflectance(
    const rsv_bsdf_tables *tables, rsv_thin_film film, float base, float cos)
{
    float n = film.ior, sin2 = f_max(1 - cos * cos, 0);
    float in = sqrtf(f_max(1 - sin2 / (n * n), 0)),
          below = sqrtf(f_max(1 - sin2 / (base * base), 0));
    // cosines of 0 on both sides of an interface: it reflects nothing between media of the same index
    float least = 1e-12f, path = 2 * n * film.thickness * in;
    float s1 = (cos - n * in) / f_max(cos + n * in, least);
    float s2 = (n * in - base * below) / f_max(n * in + base * below, least);
    float p1 = (n * cos - in) / f_max(n * cos + in, least);
    float p2 = (base * in - n * below) / f_max(base * in + n * below, least);
    rsv_rgb s = rsv_film_transmittance(tables, s1, s2, path);
    rsv_rgb p = rsv_film_transmittance(tables, p1, p2, path);
    return rgb(f_min(f_max(1 - 0.5f * (s.r + p.r), 0), 1),
        f_min(f_max(1 - 0.5f * (s.g + p.g), 0), 1), f_min(f_max(1 - 0.5f * (s.b + p.b), 0), 1));
}

/// The ior of a dielectric that reflects `f0` straight on: it stands for a metal.
RSV_INLINE float rsv_ior_of_reflectance(float f0)
{
    float root = sqrtf(f_min(f_max(f0, 0), 0.999999f));
    return (1 + root) / (1 - root);
}

/// The same over a metal of that reflectance straight on.
RSV_LARGE rsv_rgb rsv_film_reflectance_of_metal(
    const rsv_bsdf_tables *tables, rsv_thin_film film, rsv_rgb f0, float cos)
{
    rsv_rgb r = rsv_film_reflectance(tables, film, rsv_ior_of_reflectance(f0.r), cos);
    if (f0.g != f0.r) r.g = rsv_film_reflectance(tables, film, rsv_ior_of_reflectance(f0.g), cos).g;
    if (f0.b != f0.r) r.b = rsv_film_reflectance(tables, film, rsv_ior_of_reflectance(f0.b), cos).b;
    return r;
}

#endif
