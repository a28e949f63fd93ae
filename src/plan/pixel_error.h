/// Errors of pixels that few bright outliers do not decide.
#ifndef RSV_PIXEL_ERROR_H
#define RSV_PIXEL_ERROR_H

#include "resolvent/render.h"

typedef struct rsv_pixel_error_desc {
    double most; ///< that a pixel counts, either way
    /// Pixels on either side over which differences are averaged first; finer detail is lost. 0 = none
    uint32_t around;
    bool
        by_a; ///< relative to a alone: b is noisy, and dark where it has missed something
} rsv_pixel_error_desc;

/// Mean over pixels and channels of (a0 - b0) (a1 - b1), relative to the square of the surroundings in that channel,
/// like rsv_image_judgement.relative_mse. Independent noise of the differences cancels. If it is skewed, a limit per
/// pixel cuts off the products that would cancel the others: average over enough pixels to include some rare events in
/// each.
/// @param uncertainty out: standard error, assuming independent pixels
double rsv_pixel_error(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double *uncertainty);

/// The products themselves, pixel by pixel. @param map [height * width] out
void rsv_pixel_error_map(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, float *map);

/// By how much more pictures differ than averages over some pixels show, from averages over fewer: a factor, 1 or more.
/// @param a, b, desc as for rsv_pixel_error @param error, uncertainty of that
double rsv_pixel_error_averaged_away(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double error, double uncertainty);

#endif
