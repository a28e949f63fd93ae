/// Surfaces of chains, and steps from one to the next (chain.h).
#ifndef RSV_CHAIN_BODY_H
#define RSV_CHAIN_BODY_H

#include "../trace/ray.h"
#include "chain.h"

RSV_SHARED const rsv_bsdf *rsv_chain_bsdf(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_bsdf *storage)
{
    return rsv_surface_bsdf(
        scene->view, scene->bsdf, chain->triangle, chain->u, chain->v, chain->width, storage);
}

RSV_INLINE rsv_surface_point rsv_chain_seen_point(
    const rsv_transport_scene *scene, const rsv_chain *chain)
{
    return rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
}

RSV_SHARED void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain,
    rsv_vec3 *shading, rsv_vec3 *geometric)
{
    rsv_surface_point point = rsv_chain_seen_point(scene, chain);
    *shading = rsv_chain_facing_normal(chain, &point);
    *geometric = point.geometric;
}

RSV_SHARED const rsv_bsdf *rsv_chain_scattering(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *normal, rsv_bsdf *storage)
{
    rsv_surface_point seen = rsv_chain_seen_point(scene, chain);
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, storage);
    *normal = rsv_chain_bsdf_normal(bsdf, chain, &seen);
    return bsdf;
}

RSV_SHARED rsv_bsdf_branches rsv_chain_branches_at(
    const rsv_transport_scene *scene, const rsv_chain *chain, const rsv_surface_point *seen)
{
    rsv_bsdf storage;
    return rsv_chain_branches_of(rsv_chain_bsdf(scene, chain, &storage), chain, seen);
}

RSV_SHARED rsv_bsdf_branches rsv_chain_branches(
    const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_surface_point seen = rsv_chain_seen_point(scene, chain);
    return rsv_chain_branches_at(scene, chain, &seen);
}

RSV_SHARED rsv_bsdf_event rsv_chain_draw_event(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_random *random)
{
    rsv_vec3 normal;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    if (bsdf->opacity < 1 && rsv_random_float(random) >= bsdf->opacity)
        return rsv_event(RSV_LOBE_PASS, chain->direction, rgb_gray(1));
    float u_lobe = rsv_random_float(random), u1 = rsv_random_float(random);
    return rsv_bsdf_draw_event(
        bsdf, v3_neg(chain->direction), normal, !chain->back, u_lobe, u1, rsv_random_float(random));
}

RSV_SHARED rsv_bsdf_event rsv_chain_draw_specular(
    const rsv_transport_scene *scene, const rsv_chain *chain, const float u[3])
{
    rsv_vec3 normal, wo = v3_neg(chain->direction);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    rsv_bsdf_event event = rsv_bsdf_draw_specular(bsdf, wo, normal, !chain->back, u[0], u[1], u[2]);
    event.weight = rgb_scale(event.weight, bsdf->opacity);
    return event;
}

RSV_SHARED rsv_chain_move rsv_chain_step(const rsv_transport_scene *scene, rsv_chain *chain,
    bool transmit, rsv_vec3 direction, rsv_rgb weight)
{
    rsv_ray ray;
    rsv_hit hit;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    // ideal lobes never go below the triangle (rsv_bsdf_specular_normal): they leave it as it is
    if (!transmit && v3_dot(direction, point.geometric) <= 0)
        rsv_surface_lift(scene->view, scene->tracer, chain->triangle, chain->u, chain->v, &point);
    if (!rsv_chain_depart(&point, transmit, direction, &ray)) return RSV_CHAIN_LOST;
    bool meets = rsv_ray_meets(scene->tracer, &ray, &hit);
    rsv_chain_set_out(scene, chain, transmit, direction, weight);
    if (!meets) return RSV_CHAIN_LEFT_SCENE;
    rsv_chain_arrive(scene, chain, &hit);
    return RSV_CHAIN_MOVED;
}

RSV_SHARED rsv_chain_move rsv_chain_follow(
    const rsv_transport_scene *scene, rsv_chain *chain, const rsv_bsdf_event *event, rsv_rgb weight)
{
    chain->turns += event->lobe != RSV_LOBE_PASS;
    return rsv_chain_step(scene, chain, event->lobe != RSV_LOBE_REFLECT, event->direction, weight);
}

#endif
