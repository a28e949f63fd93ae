/// Robust ray origins: no fixed epsilon, no ray ever starts behind the surface it leaves.
#include "resolvent/trace.h"

#include "../core/vec.h"

rsv_vec3 rsv_offset_origin(rsv_vec3 point, rsv_vec3 normal, float extent)
{
    // A point interpolated from vertices of size M is off by a few ulp(M), and the intersection test
    // adds a few more. 64 ulp clear both: 4 um for coordinates around half a metre.
    float scale = fmaxf(extent, v3_max_abs(point));
    return v3_mad(point, 0x1p-17f * fmaxf(scale, 0x1p-60f), normal);
}

float rsv_triangle_extent(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    float a = v3_max_abs(scene->position[corner[0]]), b = v3_max_abs(scene->position[corner[1]]);
    return fmaxf(fmaxf(a, b), v3_max_abs(scene->position[corner[2]]));
}

float rsv_scene_extent(const rsv_scene_view *scene)
{
    return fmaxf(v3_max_abs(scene->bounds_min), v3_max_abs(scene->bounds_max));
}
