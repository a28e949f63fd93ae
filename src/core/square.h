/// The square onto which directions are mapped (octahedral.h), in cells; plain C, also for device code.
#ifndef RSV_SQUARE_H
#define RSV_SQUARE_H

#include "vec.h"

/// Which of side * side cells. @param x, y in [0, 1]
RSV_INLINE uint32_t rsv_square_cell(float x, float y, uint32_t side)
{
    uint32_t i = (uint32_t)(x * (float)side), j = (uint32_t)(y * (float)side);
    i = i < side ? i : side - 1;
    j = j < side ? j : side - 1;
    return j * side + i;
}

#endif
