/// The sphere as a square: octahedral map of directions (Praun and Hoppe 2003), +y in the middle; plain C,
/// also for device code.
#ifndef RSV_OCTAHEDRAL_H
#define RSV_OCTAHEDRAL_H

#include "square.h"

/// @param direction not zero, need not be unit; x and y come out in [0, 1]
RSV_INLINE void rsv_octahedral_from_direction(rsv_vec3 direction, float *x, float *y)
{
    float norm = fabsf(direction.x) + fabsf(direction.y) + fabsf(direction.z);
    float a = direction.x / norm, b = direction.z / norm;
    if (direction.y < 0) {
        float folded = (1 - fabsf(b)) * copysignf(1, a);
        b = (1 - fabsf(a)) * copysignf(1, b);
        a = folded;
    }
    *x = 0.5f + 0.5f * a;
    *y = 0.5f + 0.5f * b;
}

/// The unit direction at (x, y) in [0, 1].
RSV_INLINE rsv_vec3 rsv_octahedral_to_direction(float x, float y)
{
    float a = 2 * x - 1, b = 2 * y - 1, height = 1 - fabsf(a) - fabsf(b);
    if (height < 0) {
        float folded = (1 - fabsf(b)) * copysignf(1, a);
        b = (1 - fabsf(a)) * copysignf(1, b);
        a = folded;
    }
    return v3_normalize(v3(a, height, b));
}

/// Bin of a direction among side * side.
RSV_INLINE uint32_t rsv_octahedral_bin(rsv_vec3 direction, uint32_t side)
{
    float x, y;
    rsv_octahedral_from_direction(direction, &x, &y);
    return rsv_square_cell(x, y, side);
}

#endif
