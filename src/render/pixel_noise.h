/// Noise of pixels, and the number of further camera rays that it requires.
///
/// Rays are assigned by the noise of a pixel's neighbours, not its own, so that its mean does not depend on its number
/// of samples. By their own noise, pixels that happen to look calm would keep what they missed.
#ifndef RSV_PIXEL_NOISE_H
#define RSV_PIXEL_NOISE_H

#include "../core/vec.h"
#include "resolvent/render.h"

/// Sums over the camera rays of a pixel, of luminance: direct light is apart, as it becomes known later.
typedef struct rsv_pixel_noise {
    uint32_t count; ///< camera rays
    float sum, squares;
    float direct_sum, direct_squares;
} rsv_pixel_noise;

/// Adds the light of one camera ray, without direct light.
RSV_INLINE void rsv_pixel_noise_add(rsv_pixel_noise *noise, float luminance)
{
    noise->count++;
    noise->sum += luminance;
    noise->squares += luminance * luminance;
}

/// Sum of squared deviations among the camera rays, direct light left out.
RSV_INLINE float rsv_pixel_noise_spread(const rsv_pixel_noise *noise)
{
    if (noise->count == 0) return 0;
    return f_max(noise->squares - noise->sum * noise->sum / (float)noise->count, 0);
}

/// Adds the direct light of all of them.
RSV_INLINE void rsv_pixel_noise_add_direct(rsv_pixel_noise *noise, float sum, float squares)
{
    noise->direct_sum += sum;
    noise->direct_squares += squares;
}

/// Plans the second pass over a picture.
/// @param image   its first layer is the picture after the first pass
/// @param noise   [height * width] of that pass
/// @param samples of each pixel in that pass
/// @param wanted  target standard error of a pixel's luminance, relative to that around it, which counts as at least a
/// tenth of the
///                picture's mean
/// @param extra   out, [height * width] camera rays
void rsv_plan_samples(const rsv_image *image, const rsv_pixel_noise *noise, uint32_t samples,
    float wanted, uint32_t *extra);

#endif
