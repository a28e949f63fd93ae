/// Errors of pixels that few bright outliers do not decide.
#ifndef RSV_PIXEL_ERROR_H
#define RSV_PIXEL_ERROR_H

#include "resolvent/render.h"

/// Mean of (a0 - b0) (a1 - b1), relative to the square of what is around (as rsv_image_judgement.relative_mse is), of
/// luminance. Noise that the differences do not share cancels.
/// @param most that a pixel counts, either way
/// @param uncertainty out: standard error, pixels taken for independent
double rsv_pixel_error(
    const rsv_image *const a[2], const rsv_image *const b[2], double most, double *uncertainty);

#endif
