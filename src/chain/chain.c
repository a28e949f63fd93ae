#include "chain.h"

const rsv_bsdf *rsv_chain_bsdf(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_bsdf *storage)
{
    return rsv_surface_bsdf(
        scene->view, scene->bsdf, chain->triangle, chain->u, chain->v, chain->width, storage);
}

static rsv_surface_point seen_point(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    return rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
}

void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *shading,
    rsv_vec3 *geometric)
{
    rsv_surface_point point = seen_point(scene, chain);
    *shading = rsv_chain_facing_normal(chain, &point);
    *geometric = point.geometric;
}

const rsv_bsdf *rsv_chain_scattering(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *normal, rsv_bsdf *storage)
{
    rsv_surface_point seen = seen_point(scene, chain);
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, storage);
    *normal = rsv_chain_bsdf_normal(bsdf, chain, &seen);
    return bsdf;
}

rsv_bsdf_branches rsv_chain_branches_at(
    const rsv_transport_scene *scene, const rsv_chain *chain, const rsv_surface_point *seen)
{
    rsv_bsdf storage;
    return rsv_chain_branches_of(rsv_chain_bsdf(scene, chain, &storage), chain, seen);
}

rsv_bsdf_branches rsv_chain_branches(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_surface_point seen = seen_point(scene, chain);
    return rsv_chain_branches_at(scene, chain, &seen);
}

rsv_bsdf_event rsv_chain_draw_event(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_random *random)
{
    rsv_vec3 normal;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    if (bsdf->opacity < 1 && rsv_random_float(random) >= bsdf->opacity)
        return (rsv_bsdf_event){ RSV_LOBE_TRANSMIT, chain->direction, rgb_gray(1), 0 };
    float u_lobe = rsv_random_float(random), u1 = rsv_random_float(random);
    return rsv_bsdf_draw_event(
        bsdf, v3_neg(chain->direction), normal, !chain->back, u_lobe, u1, rsv_random_float(random));
}

rsv_bsdf_event rsv_chain_draw_specular(
    const rsv_transport_scene *scene, const rsv_chain *chain, const float u[3])
{
    rsv_vec3 normal, wo = v3_neg(chain->direction);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    rsv_bsdf_event event = rsv_bsdf_draw_specular(bsdf, wo, normal, !chain->back, u[0], u[1], u[2]);
    event.weight = rgb_scale(event.weight, bsdf->opacity);
    return event;
}

rsv_chain_move rsv_chain_step(const rsv_transport_scene *scene, rsv_chain *chain, bool transmit,
    rsv_vec3 direction, rsv_rgb weight)
{
    rsv_ray ray;
    rsv_hit hit;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    if (!rsv_chain_depart(&point, transmit, direction, &ray)) return RSV_CHAIN_LOST;
    bool meets = rsv_tracer_closest(scene->tracer, &ray, &hit);
    rsv_chain_set_out(scene, chain, transmit, direction, weight);
    if (!meets) return RSV_CHAIN_LEFT_SCENE;
    rsv_chain_arrive(scene, chain, &hit);
    return RSV_CHAIN_MOVED;
}

/// Radiance emitted along the chain by its surface, as far as that covers.
static rsv_rgb emission_towards(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, &storage);
    bool shows = bsdf->emissive && (!chain->back || bsdf->double_sided);
    return shows ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
}

/// Divides by the largest channel after having survived with that probability.
static bool survive_roulette(rsv_rgb *weight, rsv_random *random)
{
    float largest = rgb_max(*weight);
    if (largest >= 1 || largest <= 0) return largest > 0;
    if (rsv_random_float(random) >= largest) return false;
    *weight = rgb_scale(*weight, 1 / largest);
    return true;
}

rsv_gather rsv_chain_gather(const rsv_transport_scene *scene, rsv_chain chain, rsv_random *random,
    rsv_emission_filter filter, const void *user)
{
    rsv_gather gather = { .end = RSV_CHAIN_ABSORBED };
    for (;;) {
        if (filter(user, chain.triangle, chain.events))
            gather.emission =
                rgb_add(gather.emission, rgb_mul(rsv_chain_throughput(scene, &chain, &chain.medium),
                                             emission_towards(scene, &chain)));
        gather.chain = chain;
        rsv_bsdf_event event = rsv_chain_draw_event(scene, &chain, random);
        if (event.lobe == RSV_LOBE_NONE || chain.events >= RSV_CHAIN_MAX_EVENTS) return gather;
        if (event.lobe == RSV_LOBE_DIFFUSE) {
            gather.chain.weight = rgb_mul(chain.weight, event.weight);
            gather.end = survive_roulette(&gather.chain.weight, random) ? RSV_CHAIN_DIFFUSE
                                                                        : RSV_CHAIN_ABSORBED;
            gather.chain.weight = rsv_chain_throughput(scene, &gather.chain, &gather.chain.medium);
            return gather;
        }
        bool transmit = event.lobe == RSV_LOBE_TRANSMIT;
        rsv_chain_move move =
            rsv_chain_step(scene, &chain, transmit, event.direction, event.weight);
        if (move == RSV_CHAIN_LOST) return gather;
        gather.chain = chain;
        if (move == RSV_CHAIN_LEFT_SCENE) {
            gather.chain.weight = rsv_chain_throughput(scene, &chain, &chain.medium);
            gather.end = RSV_CHAIN_ESCAPED;
            return gather;
        }
        if (!survive_roulette(&chain.weight, random)) return gather;
    }
}
