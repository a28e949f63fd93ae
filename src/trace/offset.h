/// rsv_offset_origin and rsv_triangle_extent for device code too.
#ifndef RSV_OFFSET_H
#define RSV_OFFSET_H

#include "../core/vec.h"
#include "../scene/twins.h"

RSV_INLINE rsv_vec3 rsv_moved_off(rsv_vec3 point, rsv_vec3 normal, float extent)
{
    // The intersection test subtracts the origin from vertices of size M and is off by a few ulp(M); a point
    // interpolated in double is off by less. 8 ulp clear both: 0.5 um for coordinates around half a metre.
    float scale = f_max(extent, v3_max_abs(point));
    return v3_mad(point, 0x1p-20f * f_max(scale, 0x1p-60f), normal);
}

RSV_INLINE float rsv_extent_of(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    float a = v3_max_abs(scene->position[corner[0]]), b = v3_max_abs(scene->position[corner[1]]);
    float extent = f_max(f_max(a, b), v3_max_abs(scene->position[corner[2]]));
    return f_max(extent, rsv_twins_extent(scene, triangle));
}

#endif
