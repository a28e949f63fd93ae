/// The sRGB transfer function (IEC 61966-2-1), between linear light and code values in [0, 1].
#ifndef RSV_SRGB_H
#define RSV_SRGB_H

#include <math.h>

static inline double rsv_srgb_decode(double code)
{
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

static inline double rsv_srgb_encode(double linear)
{
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

#endif
