/// The GGX microsurface, isotropic, with height-correlated Smith shadowing (Walter et al. 2007, Heitz
/// 2014); plain C, also for device code. `alpha` is its width, > 0. Cosines are with the normal of the
/// surface; masking functions take them unsigned.
#ifndef RSV_GGX_H
#define RSV_GGX_H

#include "../core/vec.h"

/// Density of microfacet normals per solid angle and projected area; `n` and `h` are unit.
RSV_INLINE float rsv_ggx_distribution(rsv_vec3 n, rsv_vec3 h, float alpha)
{
    float cos_h = v3_dot(n, h);
    rsv_vec3 across =
        v3_cross(n, h); // the sine by itself: 1 - cos^2 loses narrow lobes to rounding
    float spread = v3_dot(across, across) + alpha * alpha * cos_h * cos_h;
    return cos_h > 0 ? alpha * alpha / (RSV_PI * spread * spread) : 0;
}

/// Smith's Lambda: invisible over visible microfacet area.
RSV_INLINE float rsv_ggx_lambda(float cos, float alpha)
{
    float c2 = f_max(cos * cos, 1e-12f), t2 = f_max(1 - c2, 0) / c2;
    return 0.5f * (sqrtf(1 + alpha * alpha * t2) - 1);
}

/// G2 / G1: fraction of the area visible from one direction (cos_o) that is also visible from the other.
RSV_INLINE float rsv_ggx_visibility(float cos_o, float cos_i, float alpha)
{
    float lambda_o = rsv_ggx_lambda(cos_o, alpha), lambda_i = rsv_ggx_lambda(cos_i, alpha);
    return (1 + lambda_o) / (1 + lambda_o + lambda_i);
}

/// Draws a microfacet normal as it is visible from `wo` (about normal z, wo.z >= 0), through spherical
/// caps (Dupuy and Benyoub 2023).
/// @param x, y widths along the axes
RSV_INLINE rsv_vec3 rsv_ggx_sample_visible_xy(rsv_vec3 wo, float x, float y, float u1, float u2)
{
    rsv_vec3 stretched = v3_normalize(v3(x * wo.x, y * wo.y, wo.z));
    float z = (1 - u2) * (1 + stretched.z) - stretched.z, phi = 2 * RSV_PI * u1;
    float r = sqrtf(f_max(1 - z * z, 0));
    rsv_vec3 cap = v3_add(v3(r * cosf(phi), r * sinf(phi), z), stretched);
    return v3_normalize(v3(x * cap.x, y * cap.y, f_max(cap.z, 1e-7f)));
}
RSV_INLINE rsv_vec3 rsv_ggx_sample_visible(rsv_vec3 wo, float alpha, float u1, float u2)
{
    return rsv_ggx_sample_visible_xy(wo, alpha, alpha, u1, u2);
}

/// Density per solid angle of rsv_ggx_sample_visible's normals.
RSV_INLINE float rsv_ggx_visible_pdf(rsv_vec3 n, rsv_vec3 h, rsv_vec3 wo, float alpha)
{
    float cos_o = f_max(v3_dot(n, wo), 1e-6f);
    return rsv_ggx_distribution(n, h, alpha) * f_max(v3_dot(wo, h), 0) /
           (cos_o * (1 + rsv_ggx_lambda(cos_o, alpha)));
}

// ---- of two widths, along the axes x and y of a frame about the normal z ---------------------------

RSV_INLINE float rsv_ggx_lambda_xy(rsv_vec3 w, float x, float y)
{
    float across = x * x * w.x * w.x + y * y * w.y * w.y;
    return 0.5f * (sqrtf(1 + across / f_max(w.z * w.z, 1e-12f)) - 1);
}

RSV_INLINE float rsv_ggx_visibility_xy(rsv_vec3 wo, rsv_vec3 wi, float x, float y)
{
    float lambda_o = rsv_ggx_lambda_xy(wo, x, y);
    return (1 + lambda_o) / (1 + lambda_o + rsv_ggx_lambda_xy(wi, x, y));
}

/// Density per solid angle of rsv_ggx_sample_visible_xy's normals.
RSV_INLINE float rsv_ggx_visible_pdf_xy(rsv_vec3 h, rsv_vec3 wo, float x, float y)
{
    float a = h.x / x, b = h.y / y, spread = a * a + b * b + h.z * h.z;
    float distribution = h.z > 0 ? 1 / (RSV_PI * x * y * spread * spread) : 0;
    return distribution * f_max(v3_dot(wo, h), 0) /
           (f_max(wo.z, 1e-6f) * (1 + rsv_ggx_lambda_xy(wo, x, y)));
}

#endif
