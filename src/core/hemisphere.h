/// The hemisphere about +z as a square: rings about the middle, the horizon along the border, areas as on the sphere; plain
/// C, also for device code.
///
/// Lambert's azimuthal disk under Shirley and Chiu's concentric map (1997), whose arc tangent is a parabola here: cells
/// come out within 7 % of equal. Clamping to the border clamps to the horizon.
#ifndef RSV_HEMISPHERE_H
#define RSV_HEMISPHERE_H

#include "square.h"

/// @param direction unit; below the horizon counts as on it @param x, y out: in [0, 1]
RSV_INLINE void rsv_hemisphere_to_square(rsv_vec3 direction, float *x, float *y)
{
    float a = fabsf(direction.x), b = fabsf(direction.y);
    float radius = sqrtf(1 - f_min(f_max(direction.z, 0), 1));
    float most = f_max(f_max(a, b), 1e-20f), q = f_min(a, b) / most;
    float along = 0.5f * radius, across = along * q * (1.3476f - 0.3476f * q);
    *x = 0.5f + copysignf(a >= b ? along : across, direction.x);
    *y = 0.5f + copysignf(a >= b ? across : along, direction.y);
}

/// Which of side * side cells.
RSV_INLINE uint32_t rsv_hemisphere_cell(rsv_vec3 direction, uint32_t side)
{
    float x, y;
    rsv_hemisphere_to_square(direction, &x, &y);
    return rsv_square_cell(x, y, side);
}

#endif
