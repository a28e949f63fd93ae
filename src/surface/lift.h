/// Coarse triangles with smooth normals represent a curved surface that bulges above them. Light at grazing angles hits
/// the planes of the triangles from behind, or their neighbours, and shadows follow the facets. Rays that graze a
/// convex triangle therefore start from the curved surface, given by the planes perpendicular to the vertices' normals
/// (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021). The normal of that surface decides which light
/// is above it. Other rays start from the triangle, so that objects that touch it still cast shadows.
///
/// Used by all receivers of light, through receiver/receiver.h. The path tracer has separate code for the same surface
/// (reference/path_surface.c).
#ifndef RSV_LIFT_H
#define RSV_LIFT_H

#include "../trace/ray.h"
#include "surface.h"

/// Normals of a triangle's corners that differ by less (1 - cosine) are those of a flat one: 0.08 degrees.
#define RSV_FLAT_NORMALS 1e-6f

/// Rays whose cosine with the triangle's normal is larger start from the triangle.
#define RSV_GRAZING 0.1f

RSV_INLINE bool rsv_normals_are_flat(const rsv_vec3 normal[3])
{
    for (int k = 0; k < 3; k++) {
        rsv_vec3 a = normal[k], b = normal[(k + 1) % 3];
        bool same = a.x == b.x && a.y == b.y && a.z == b.z;
        if (!same && v3_dot(v3_normalize(a), v3_normalize(b)) < 1 - RSV_FLAT_NORMALS) return false;
    }
    return true;
}

/// From a point of a triangle to the convex surface that it stands for; the zero vector where that does not rise above
/// it.
/// @param side 1 or -1, of the triangle
RSV_INLINE rsv_vec3 rsv_lift_of(const rsv_vec3 corner[3], const rsv_vec3 normal[3], float u,
    float v, const rsv_surface_point *point, float side)
{
    const float weight[3] = { 1 - u - v, u, v };
    rsv_vec3 lift = v3(0, 0, 0);
    for (int k = 0; k < 3; k++) {
        rsv_vec3 n = v3_scale(v3_normalize(normal[k]), side);
        if (!(v3_dot(n, point->geometric) > 0)) return v3(0, 0, 0);
        float below = f_min(v3_dot(v3_sub(point->position, corner[k]), n), 0);
        lift = v3_mad(lift, -weight[k] * below, n);
    }
    return lift;
}

/// Lifts a point of a triangle, on the side of its geometric normal, to the curved surface, unless something lies
/// between.
RSV_INLINE void rsv_surface_lift(const rsv_scene_view *scene, const rsv_tracer *tracer,
    uint32_t triangle, float u, float v, rsv_surface_point *point)
{
    const uint32_t *at = scene->triangle[triangle];
    rsv_vec3 normal[3] = { scene->normal[at[0]], scene->normal[at[1]], scene->normal[at[2]] };
    if (rsv_normals_are_flat(normal)) return;
    rsv_vec3 corner[3] = { scene->position[at[0]], scene->position[at[1]], scene->position[at[2]] };
    rsv_vec3 front = v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0]));
    float side = v3_dot(front, point->geometric) < 0 ? -1.0f : 1.0f;
    rsv_vec3 lift = rsv_lift_of(corner, normal, u, v, point, side);
    if (!(v3_dot(lift, lift) > 0)) return;
    rsv_ray up = { rsv_moved_off(point->position, point->geometric, point->extent), lift, 1 };
    if (rsv_ray_passed(tracer, &up) < 1) return;
    rsv_vec3 smooth = v3_normalize(v3_barycentric(normal[0], normal[1], normal[2], u, v));
    point->lift = lift;
    point->horizon = v3_scale(smooth, side);
}

/// Where a ray that leaves along unit `direction` starts. @param origin off the triangle
RSV_INLINE rsv_vec3 rsv_lifted_origin(
    const rsv_surface_point *point, rsv_vec3 origin, rsv_vec3 direction)
{
    float grazing = 1 - v3_dot(point->geometric, direction) / RSV_GRAZING;
    return grazing > 0 ? v3_mad(origin, f_min(grazing, 1), point->lift) : origin;
}

RSV_INLINE bool rsv_is_lifted(const rsv_surface_point *point)
{
    return v3_dot(point->lift, point->lift) > 0;
}

/// Gives a ray that was aimed from the triangle its start; its end stays.
RSV_INLINE void rsv_lift_ray(const rsv_surface_point *point, rsv_ray *ray)
{
    if (!rsv_is_lifted(point)) return;
    rsv_vec3 origin = rsv_lifted_origin(point, ray->origin, v3_normalize(ray->direction));
    if (ray->t_max < INFINITY)
        ray->direction = v3_mad(ray->direction, -1 / ray->t_max, v3_sub(origin, ray->origin));
    ray->origin = origin;
}

#endif
