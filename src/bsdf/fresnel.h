/// Reflectance of smooth interfaces; plain C, also for device code.
#ifndef RSV_FRESNEL_H
#define RSV_FRESNEL_H

#include "../core/vec.h"

/// Unpolarised Fresnel reflectance of a smooth dielectric interface.
/// @param cos_i cosine on the incident side, >= 0
/// @param eta   ior of the far side / ior of the incident side
/// @param cos_t cosine on the far side, >= 0; 0 on total internal reflection
/// @return 1 on total internal reflection
RSV_INLINE float rsv_fresnel_dielectric(float cos_i, float eta, float *cos_t)
{
    if (eta == 1) {
        *cos_t = cos_i;
        return 0;
    }
    float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1) {
        *cos_t = 0;
        return 1;
    }
    *cos_t = sqrtf(1 - sin2_t);
    float perpendicular = (cos_i - eta * *cos_t) / (cos_i + eta * *cos_t);
    float parallel = (eta * cos_i - *cos_t) / (eta * cos_i + *cos_t);
    return 0.5f * (perpendicular * perpendicular + parallel * parallel);
}

/// Schlick's approximation for a metal whose reflectance at normal incidence is `f0`.
RSV_INLINE rsv_rgb rsv_fresnel_schlick(rsv_rgb f0, float cos)
{
    float x = 1 - cos, x5 = x * x * (x * x) * x;
    return rgb_mad(f0, x5, rgb_sub(rgb_gray(1), f0));
}

/// Hemispherical mean 2 int F cos dcos of Schlick's approximation.
RSV_INLINE rsv_rgb rsv_fresnel_schlick_mean(rsv_rgb f0)
{
    return rgb_mad(f0, 1.0f / 21, rgb_sub(rgb_gray(1), f0));
}

/// Unpolarised reflectance of a conductor with complex index eta + i k (relative).
float rsv_fresnel_conductor(float cos_i, float eta, float k);

/// Hemispherical mean 2 int F cos dcos of the dielectric reflectance from outside, eta >= 1
/// (Walsh's closed form); from inside it is 1 - (1 - mean) / eta^2.
double rsv_fresnel_dielectric_mean(double eta);

#endif
