/// Surfaces of specular paths, and steps from one to the next (specular path.h).
#ifndef RSV_SPECULAR_BODY_H
#define RSV_SPECULAR_BODY_H

#include "../trace/ray.h"
#include "specular_path.h"

RSV_SHARED const rsv_bsdf *rsv_specular_bsdf(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_bsdf *storage)
{
    rsv_footprint at = { path->triangle, path->u, path->v, path->width,
        rsv_specular_channel(scene, path) };
    return rsv_surface_bsdf(scene->view, scene->bsdf, at, storage);
}

RSV_INLINE rsv_surface_point rsv_specular_seen_point(
    const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    return rsv_surface_point_seen(
        scene->view, path->triangle, path->u, path->v, path->back, path->width);
}

RSV_SHARED void rsv_specular_normals(const rsv_transport_scene *scene,
    const rsv_specular_path *path, rsv_vec3 *shading, rsv_vec3 *geometric)
{
    rsv_surface_point point = rsv_specular_seen_point(scene, path);
    *shading = rsv_specular_facing_normal(path, &point);
    *geometric = point.geometric;
}

RSV_SHARED const rsv_bsdf *rsv_specular_scattering(const rsv_transport_scene *scene,
    const rsv_specular_path *path, rsv_vec3 *normal, rsv_bsdf *storage)
{
    rsv_surface_point seen = rsv_specular_seen_point(scene, path);
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene, path, storage);
    *normal = rsv_specular_bsdf_normal(bsdf, path, &seen);
    return bsdf;
}

RSV_SHARED rsv_bsdf_branches rsv_specular_branches_at(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_surface_point *seen)
{
    rsv_bsdf storage;
    return rsv_specular_branches_of(rsv_specular_bsdf(scene, path, &storage), path, seen);
}

RSV_SHARED rsv_bsdf_branches rsv_specular_branches(
    const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    rsv_surface_point seen = rsv_specular_seen_point(scene, path);
    return rsv_specular_branches_at(scene, path, &seen);
}

RSV_SHARED rsv_bsdf_event rsv_specular_draw_event(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_random *random)
{
    rsv_vec3 normal;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_scattering(scene, path, &normal, &storage);
    if (bsdf->opacity < 1 && rsv_random_float(random) >= bsdf->opacity)
        return rsv_event(RSV_LOBE_PASS, path->direction, rgb_gray(1));
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(random);
    return rsv_bsdf_draw_event(bsdf, v3_neg(path->direction), normal, !path->back, u);
}

RSV_SHARED rsv_bsdf_event rsv_specular_draw_specular(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const float u[3])
{
    rsv_vec3 normal, wo = v3_neg(path->direction);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_scattering(scene, path, &normal, &storage);
    rsv_bsdf_event event = rsv_bsdf_draw_specular(bsdf, wo, normal, !path->back, u);
    event.weight = rgb_scale(event.weight, bsdf->opacity);
    return event;
}

RSV_SHARED rsv_specular_move rsv_specular_step(const rsv_transport_scene *scene,
    rsv_specular_path *path, bool transmit, rsv_vec3 direction, rsv_rgb weight)
{
    rsv_ray ray;
    rsv_hit hit;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back);
    // ideal lobes never go below the triangle (rsv_bsdf_specular_normal): they leave it as it is
    if (!transmit && v3_dot(direction, point.geometric) <= 0)
        rsv_surface_lift(scene->view, scene->tracer, path->triangle, path->u, path->v, &point);
    if (!rsv_specular_depart(&point, transmit, direction, &ray)) return RSV_SPECULAR_LOST;
    bool meets = rsv_ray_meets(scene->tracer, &ray, &hit);
    rsv_specular_set_out(scene, path, transmit, direction, weight);
    if (!meets) return RSV_SPECULAR_LEFT_SCENE;
    rsv_specular_arrive(scene, path, &hit);
    return RSV_SPECULAR_MOVED;
}

RSV_SHARED rsv_specular_move rsv_specular_follow(const rsv_transport_scene *scene,
    rsv_specular_path *path, const rsv_bsdf_event *event, rsv_rgb weight)
{
    path->turns += event->lobe != RSV_LOBE_PASS;
    return rsv_specular_step(
        scene, path, event->lobe != RSV_LOBE_REFLECT, event->direction, weight);
}

#endif
