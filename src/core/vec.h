/// Arithmetic on rsv_vec3 and rsv_rgb; plain C, also for device code.
#ifndef RSV_VEC_H
#define RSV_VEC_H

#include "resolvent/core.h"

#include <math.h>

#ifndef RSV_INLINE
#if defined(__CUDACC__)
#define RSV_INLINE static inline __host__ __device__
#else
#define RSV_INLINE static inline
#endif
#endif

/// An inline function that device code calls, being large.
#if defined(__CUDACC__)
#define RSV_LARGE static __host__ __device__ __noinline__ __attribute__((unused))
#else
#define RSV_LARGE RSV_INLINE
#endif

/// Functions that the library compiles once, and device code inline. Their bodies are in headers `*_body.h`, which a
/// source file of the library includes; if RSV_DEVICE_CODE is defined, the header itself includes them.
#ifndef RSV_SHARED
#if defined(RSV_DEVICE_CODE) && defined(__CUDACC__)
#define RSV_SHARED                                                                                 \
    RSV_LARGE // a kernel may reach dozens of them: compiled into it, that takes minutes
#elif defined(RSV_DEVICE_CODE)
#define RSV_SHARED RSV_INLINE
#else
#define RSV_SHARED
#endif
#endif

/// Ahead of a loop that device code is to keep as a loop: unrolled, long ones compile for minutes.
#if defined(__CUDACC__)
#define RSV_ROLLED _Pragma("unroll 1")
#else
#define RSV_ROLLED
#endif

#define RSV_PI 3.14159265358979323846f

/// Compiled to one instruction, unlike fminf and fmaxf, which care about NaN; the second argument survives
/// a NaN in the first.
RSV_INLINE float f_min(float a, float b) { return a < b ? a : b; }
RSV_INLINE float f_max(float a, float b) { return a > b ? a : b; }

RSV_INLINE rsv_vec3 v3(float x, float y, float z)
{
    rsv_vec3 r = { x, y, z };
    return r;
}
RSV_INLINE rsv_vec3 v3_add(rsv_vec3 a, rsv_vec3 b) { return v3(a.x + b.x, a.y + b.y, a.z + b.z); }
RSV_INLINE rsv_vec3 v3_sub(rsv_vec3 a, rsv_vec3 b) { return v3(a.x - b.x, a.y - b.y, a.z - b.z); }
RSV_INLINE rsv_vec3 v3_scale(rsv_vec3 a, float s) { return v3(a.x * s, a.y * s, a.z * s); }
RSV_INLINE rsv_vec3 v3_neg(rsv_vec3 a) { return v3(-a.x, -a.y, -a.z); }
/// a + s b
RSV_INLINE rsv_vec3 v3_mad(rsv_vec3 a, float s, rsv_vec3 b)
{
    return v3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
RSV_INLINE float v3_dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
RSV_INLINE rsv_vec3 v3_cross(rsv_vec3 a, rsv_vec3 b)
{
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
RSV_INLINE float v3_length(rsv_vec3 a) { return sqrtf(v3_dot(a, a)); }
/// a / |a|; the zero vector stays zero.
RSV_INLINE rsv_vec3 v3_normalize(rsv_vec3 a)
{
    float length = v3_length(a);
    return length > 0 ? v3_scale(a, 1 / length) : a;
}
RSV_INLINE float v3_max_abs(rsv_vec3 a) { return f_max(fabsf(a.x), f_max(fabsf(a.y), fabsf(a.z))); }
RSV_INLINE rsv_vec3 v3_min(rsv_vec3 a, rsv_vec3 b)
{
    return v3(f_min(a.x, b.x), f_min(a.y, b.y), f_min(a.z, b.z));
}
RSV_INLINE rsv_vec3 v3_max(rsv_vec3 a, rsv_vec3 b)
{
    return v3(f_max(a.x, b.x), f_max(a.y, b.y), f_max(a.z, b.z));
}
/// (1 - u - v) a + u b + v c, in double: a point of a triangle lies in its plane to its own last place.
RSV_INLINE rsv_vec3 v3_barycentric(rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, float u, float v)
{
    double p = u, q = v, o = 1 - p - q;
    return v3((float)(o * a.x + p * b.x + q * c.x), (float)(o * a.y + p * b.y + q * c.y),
        (float)(o * a.z + p * b.z + q * c.z));
}

/// Two unit tangents that make a right-handed frame (t, b, n) with unit n (Duff et al. 2017).
RSV_INLINE void v3_frame(rsv_vec3 n, rsv_vec3 *t, rsv_vec3 *b)
{
    float sign = copysignf(1.0f, n.z);
    float p = -1.0f / (sign + n.z), q = n.x * n.y * p;
    *t = v3(1.0f + sign * n.x * n.x * p, sign * q, -sign * n.x);
    *b = v3(q, sign + n.y * n.y * p, -n.y);
}

/// A direction given about the z axis, turned so that this axis becomes the unit vector `axis`.
RSV_INLINE rsv_vec3 v3_turned_to(rsv_vec3 axis, rsv_vec3 local)
{
    rsv_vec3 t, b;
    v3_frame(axis, &t, &b);
    return v3_mad(v3_mad(v3_scale(t, local.x), local.y, b), local.z, axis);
}

RSV_INLINE rsv_rgb rgb(float r, float g, float b)
{
    rsv_rgb c = { r, g, b };
    return c;
}
RSV_INLINE rsv_rgb rgb_gray(float v) { return rgb(v, v, v); }
RSV_INLINE rsv_rgb rgb_add(rsv_rgb a, rsv_rgb b) { return rgb(a.r + b.r, a.g + b.g, a.b + b.b); }
RSV_INLINE rsv_rgb rgb_sub(rsv_rgb a, rsv_rgb b) { return rgb(a.r - b.r, a.g - b.g, a.b - b.b); }
RSV_INLINE rsv_rgb rgb_mul(rsv_rgb a, rsv_rgb b) { return rgb(a.r * b.r, a.g * b.g, a.b * b.b); }
/// Nothing below 0, and no NaN.
RSV_INLINE rsv_rgb rgb_positive(rsv_rgb a)
{
    return rgb(f_max(a.r, 0), f_max(a.g, 0), f_max(a.b, 0));
}
RSV_INLINE rsv_rgb rgb_scale(rsv_rgb a, float s) { return rgb(a.r * s, a.g * s, a.b * s); }
/// a + s b
RSV_INLINE rsv_rgb rgb_mad(rsv_rgb a, float s, rsv_rgb b)
{
    return rgb(a.r + s * b.r, a.g + s * b.g, a.b + s * b.b);
}
RSV_INLINE float rgb_max(rsv_rgb a) { return f_max(a.r, f_max(a.g, a.b)); }
RSV_INLINE bool rgb_is_black(rsv_rgb a) { return a.r == 0 && a.g == 0 && a.b == 0; }
/// Rec. 709 luminance
RSV_INLINE float rgb_luminance(rsv_rgb a) { return 0.2126f * a.r + 0.7152f * a.g + 0.0722f * a.b; }

#endif
