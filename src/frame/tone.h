/// From radiance to codes: plain C, also for device code.
#ifndef RSV_TONE_H
#define RSV_TONE_H

#include "../core/vec.h"

#include <string.h>

/// How a frame is shown.
typedef struct rsv_frame_tone {
    float scale; ///< 2^exposure / samples
    bool soft;
    bool first; ///< sample of its pixel: sums start over
} rsv_frame_tone;

/// 1.055 * 255 * 2^(5/12 e) for the exponents e = -15 .. 0: by the last four bits of a float's own exponent.
RSV_INLINE const float *rsv_srgb_octaves(void)
{
    static const float octave[16] = { 3.5347212f, 4.7182868f, 6.2981572f, 8.4070312f, 11.2220404f,
        14.9796267f, 19.9954028f, 26.6906605f, 35.6277574f, 47.5573505f, 63.4814467f, 84.7375651f,
        113.1110791f, 150.9851763f, 201.5410307f, 269.025f };
    return octave;
}

/// Place of x in rsv_srgb_octaves.
RSV_INLINE int rsv_srgb_octave_of(float x)
{
    int bits;
    memcpy(&bits, &x, sizeof bits);
    return bits >> 23 & 15;
}

/// The sRGB curve over [0, 1] times 255, off by 0.003 codes at most: 5/12 of the exponent come from a table, and those
/// of the mantissa from a polynomial. @param octave of rsv_srgb_octaves
RSV_INLINE float rsv_srgb_code(float x, float octave)
{
    int bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits & 0x7fffff) | 0x3f800000;
    float m;
    memcpy(&m, &bits, sizeof m);
    float power = -0.011024264f;
    power = power * m + 0.09020028f;
    power = power * m - 0.32084154f;
    power = power * m + 0.8313053f;
    power = power * m + 0.4103693f;
    return x <= 0.0031308f ? 255 * 12.92f * x : power * octave - 0.055f * 255;
}

/// Radiance as shown, 0 .. 1. @param x radiance times 2^exposure
RSV_INLINE float rsv_tone_shown(float x, bool soft)
{
    x = f_max(x, 0);
    return f_min(soft ? x * (1 + x * (1.0f / 16)) / (1 + x) : x, 1);
}

/// A code, 0 .. 255.
RSV_INLINE int rsv_tone_code(float x, bool soft)
{
    float shown = rsv_tone_shown(x, soft);
    return (int)(rsv_srgb_code(shown, rsv_srgb_octaves()[rsv_srgb_octave_of(shown)]) + 0.5f);
}

#endif
