/// Rays of code that the library and devices share.
#ifndef RSV_TRACE_RAY_H
#define RSV_TRACE_RAY_H

#include "../scene/material_at.h"
#include "offset.h"
#include "passage.h"

#if defined(RSV_DEVICE_CODE)

#include "../bvh/bvh_trace.h"

/// There, it is a hierarchy.
struct rsv_tracer {
    rsv_bvh_view bvh;
};

RSV_INLINE bool rsv_ray_meets(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    return rsv_bvh_closest(&tracer->bvh, ray, hit);
}

#else

static inline bool rsv_ray_meets(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    return rsv_tracer_closest(tracer, ray, hit);
}

#endif

/// Goes on beyond a surface that was met, to the same end.
RSV_INLINE void rsv_ray_go_on(const rsv_scene_view *scene, const rsv_hit *hit, rsv_ray *ray)
{
    const uint32_t *corner = scene->triangle[hit->triangle];
    rsv_vec3 a = scene->position[corner[0]], b = scene->position[corner[1]];
    rsv_vec3 c = scene->position[corner[2]];
    rsv_vec3 onward = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    if (v3_dot(onward, ray->direction) < 0) onward = v3_neg(onward);
    rsv_vec3 end = v3_mad(ray->origin, ray->t_max, ray->direction);
    ray->origin = rsv_moved_off(
        v3_barycentric(a, b, c, hit->u, hit->v), onward, rsv_extent_of(scene, hit->triangle));
    if (!(ray->t_max < INFINITY)) return;
    ray->direction = v3_sub(end, ray->origin);
    ray->t_max = 1;
}

/// Surfaces that light passes at most: more than any stack of leaves.
#define RSV_MOST_VEILS 1024

/// Straight transmittance of a ray, surface by surface.
RSV_INLINE float rsv_pass_blended(
    const rsv_tracer *tracer, const rsv_scene_view *scene, rsv_ray ray)
{
    float passed = 1;
    rsv_hit hit;
    for (int met = 0; met < RSV_MOST_VEILS && passed > 0 && rsv_ray_meets(tracer, &ray, &hit);
         met++) {
        passed *= 1 - rsv_opacity_at(scene, hit.triangle, hit.u, hit.v);
        rsv_ray_go_on(scene, &hit, &ray);
    }
    return passed;
}

/// rsv_tracer_passed
RSV_INLINE float rsv_ray_passed(const rsv_tracer *tracer, const rsv_ray *ray)
{
#if defined(RSV_DEVICE_CODE)
    if (!rsv_bvh_occluded(&tracer->bvh, ray)) return 1;
    return tracer->bvh.holes ? rsv_pass_blended(tracer, tracer->bvh.holes, *ray) : 0;
#else
    return rsv_tracer_passed(tracer, ray);
#endif
}

#endif
