/// A few pixels all over a picture, at which a question is answered that would cost too much at all of them.
#ifndef RSV_SPOTS_H
#define RSV_SPOTS_H

#include <stdint.h>

/// Chooses one pixel at random in each block of a grid.
/// @param number of pixels, approximately; all of them if there are no more
/// @param count out, [height * width]: `samples` for chosen pixels, 0 for others
void rsv_choose_spots(uint32_t width, uint32_t height, uint32_t number, uint32_t seed,
    uint32_t samples, uint32_t *count);

#endif
