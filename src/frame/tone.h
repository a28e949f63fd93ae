/// From radiance to codes: plain C, also for device code.
#ifndef RSV_TONE_H
#define RSV_TONE_H

#include "../core/vec.h"

/// How a frame is shown.
typedef struct rsv_frame_tone {
    float scale; ///< 2^exposure / samples
    bool soft;
    bool first; ///< sample of its pixel: sums start over
} rsv_frame_tone;

/// The sRGB curve over [0, 1] times 255: a polynomial in x^(1/4), off by 0.013 codes at most.
RSV_INLINE float rsv_srgb_code(float x)
{
    float q = sqrtf(sqrtf(x));
    float curve = 0.0764924974571757f;
    curve = curve * q - 0.3234316818625122f;
    curve = curve * q + 1.1120896146387176f;
    curve = curve * q + 0.1999536208759521f;
    curve = curve * q - 0.06508130912720766f;
    return 255 * (x <= 0.0031308f ? 12.92f * x : curve);
}

/// A code, 0 .. 255. @param x radiance times 2^exposure
RSV_INLINE int rsv_tone_code(float x, bool soft)
{
    x = f_max(x, 0);
    x = soft ? x * (1 + x * (1.0f / 16)) / (1 + x) : x;
    return (int)(rsv_srgb_code(f_min(x, 1)) + 0.5f);
}

#endif
