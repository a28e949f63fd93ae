/// Robust ray origins: no fixed epsilon, no ray ever starts behind the surface it leaves.
#include "resolvent/trace.h"

#include "../core/vec.h"

rsv_vec3 rsv_offset_origin(rsv_vec3 point, rsv_vec3 normal, float extent)
{
    // A point interpolated from vertices of size M is off by a few ulp(M), and the intersection test
    // adds a few more. 64 ulp clear both: 4 um for coordinates around half a metre.
    float scale = f_max(extent, v3_max_abs(point));
    return v3_mad(point, 0x1p-17f * f_max(scale, 0x1p-60f), normal);
}

float rsv_triangle_extent(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    float a = v3_max_abs(scene->position[corner[0]]), b = v3_max_abs(scene->position[corner[1]]);
    return f_max(f_max(a, b), v3_max_abs(scene->position[corner[2]]));
}

float rsv_scene_extent(const rsv_scene_view *scene)
{
    return f_max(v3_max_abs(scene->bounds_min), v3_max_abs(scene->bounds_max));
}
