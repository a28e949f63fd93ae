/// Pixels whose stored light is too wrong to be looked up: their camera rays send gather rays.
///
/// In furnished rooms, most of the elements' error is in few pixels: a tenth of them has five sixths of it, where
/// furniture stands close together. Gathering there costs less than finer elements everywhere.
#ifndef RSV_SELECTION_H
#define RSV_SELECTION_H

#include "resolvent/render.h"

typedef struct rsv_selection_desc {
    double limit; ///< squared relative error above which a pixel is chosen
    double
        rays; ///< gather rays of each pixel: the fewer, the more pixels around it are judged with it
} rsv_selection_desc;

/// Chooses pixels whose error is probably above the limit.
/// @param stored, gathered two independent pictures each; those of the same index differ only in how they get indirect
/// light
/// @param chosen [height * width] out @return the fraction of pixels chosen
double rsv_select_pixels(const rsv_image *const stored[2], const rsv_image *const gathered[2],
    const rsv_selection_desc *desc, uint8_t *chosen);

#endif
