/// Robust ray origins: no fixed epsilon, no ray ever starts behind the surface it leaves.
#include "offset.h"
#include "resolvent/trace.h"

rsv_vec3 rsv_offset_origin(rsv_vec3 point, rsv_vec3 normal, float extent)
{
    return rsv_moved_off(point, normal, extent);
}

float rsv_triangle_extent(const rsv_scene_view *scene, uint32_t triangle)
{
    return rsv_extent_of(scene, triangle);
}

float rsv_scene_extent(const rsv_scene_view *scene)
{
    return f_max(v3_max_abs(scene->bounds_min), v3_max_abs(scene->bounds_max));
}

rsv_vec3 rsv_tracer_receiver_origin(const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_scene(tracer));
    // Looked for within many times the scene's rounding (points come from text, and planes are tilted), moved by
    // that of the triangle found: in a small room on a large floor the former can be millimetres.
    float reach = 0x1p-16f * rsv_scene_extent(scene);
    rsv_vec3 above = v3_mad(point, reach, normal);
    rsv_ray down = { above, v3_neg(normal), 2 * reach };
    rsv_hit hit;
    if (!rsv_tracer_closest(tracer, &down, &hit)) return point;
    rsv_vec3 surface = v3_mad(above, -hit.t, normal);
    rsv_vec3 origin = rsv_offset_origin(surface, normal, rsv_triangle_extent(scene, hit.triangle));
    // a surface below the point by more than its own rounding does not carry it
    return v3_dot(v3_sub(origin, point), normal) > 0 ? origin : point;
}
