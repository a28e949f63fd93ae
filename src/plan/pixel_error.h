/// Relative squared errors of pixels.
#ifndef RSV_PIXEL_ERROR_H
#define RSV_PIXEL_ERROR_H

#include "resolvent/render.h"

typedef struct rsv_pixel_error_desc {
    double most; ///< that a pixel counts, either way
    /// [2] light that errors are relative to, where pictures are too noisy for that or have gaps; NULL = that of all four
    const rsv_image *const *light;
    const uint32_t *spots; ///< [height * width] pixels with 0 are left out; NULL = none
} rsv_pixel_error_desc;

/// Mean over pixels and channels of (a0 - b0) (a1 - b1), relative to the square of the surroundings in that channel,
/// like rsv_image_judgement.relative_mse. Independent noise of the differences cancels. If it is skewed, a limit per
/// pixel cuts off the products that would cancel the others.
/// @param uncertainty out: standard error, assuming independent pixels
double rsv_pixel_error(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double *uncertainty);

/// (a - b)^2 at each pixel, mean over the channels, relative to the square of the mean around it. There, the pixel
/// itself counts with the lower of a and b: a spark in one of them must not hide itself.
/// @param mean of the picture, with or before a and b @param map [height * width] out
void rsv_pixel_squares(const rsv_image *mean, const rsv_image *a, const rsv_image *b, float *map);

#endif
