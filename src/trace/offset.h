/// rsv_offset_origin for device code too.
#ifndef RSV_OFFSET_H
#define RSV_OFFSET_H

#include "../core/vec.h"

RSV_INLINE rsv_vec3 rsv_moved_off(rsv_vec3 point, rsv_vec3 normal, float extent)
{
    // The intersection test subtracts the origin from vertices of size M and is off by a few ulp(M); a point
    // interpolated in double is off by less. 8 ulp clear both: 0.5 um for coordinates around half a metre.
    float scale = f_max(extent, v3_max_abs(point));
    return v3_mad(point, 0x1p-20f * f_max(scale, 0x1p-60f), normal);
}

#endif
