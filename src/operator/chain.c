#include "chain.h"

#include "elements.h"

rsv_chain rsv_chain_begin(const rsv_transport_scene *scene, rsv_vec3 direction, uint32_t triangle,
    float u, float v, float t)
{
    rsv_chain chain = { .direction = direction,
        .weight = rgb_gray(1),
        .triangle = triangle,
        .u = u,
        .v = v,
        .spread = RSV_GATHER_SPREAD,
        .width = RSV_GATHER_SPREAD * t };
    const uint32_t *corner = scene->view->triangle[triangle];
    rsv_vec3 a = scene->view->position[corner[0]];
    rsv_vec3 normal = v3_cross(
        v3_sub(scene->view->position[corner[1]], a), v3_sub(scene->view->position[corner[2]], a));
    chain.back = v3_dot(normal, direction) > 0;
    // what a body is made of is the same all over
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[triangle]];
    // Arriving at the inside of a body's surface means the segment ran through the body.
    if (chain.back && bsdf->solid && !rgb_is_black(bsdf->absorption))
        chain.weight = rgb(expf(-bsdf->absorption.r * t), expf(-bsdf->absorption.g * t),
            expf(-bsdf->absorption.b * t));
    return chain;
}

void rsv_chain_set_spread(rsv_chain *chain, float spread, float distance)
{
    chain->spread = spread;
    chain->width = spread * distance;
}

const rsv_bsdf *rsv_chain_bsdf(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_bsdf *storage)
{
    return rsv_surface_bsdf(
        scene->view, scene->bsdf, chain->triangle, chain->u, chain->v, chain->width, storage);
}

void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *shading,
    rsv_vec3 *geometric)
{
    rsv_surface_point point = rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
    *shading = point.normal;
    *geometric = point.geometric;
    // a silhouette seen under an interpolated normal that already turns away
    if (v3_dot(*shading, chain->direction) >= 0) *shading = *geometric;
}

const rsv_bsdf *rsv_chain_scattering(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *normal, rsv_bsdf *storage)
{
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, storage);
    rsv_vec3 geometric;
    rsv_chain_normals(scene, chain, normal, &geometric);
    if (!bsdf->lambert)
        *normal = rsv_bsdf_specular_normal(*normal, geometric, v3_neg(chain->direction));
    return bsdf;
}

rsv_bsdf_branches rsv_chain_branches(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_vec3 normal;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    rsv_bsdf_branches branches =
        rsv_bsdf_evaluate_branches(bsdf, v3_neg(chain->direction), normal, !chain->back);
    if (bsdf->opacity >= 1) return branches;
    branches.reflect = rgb_scale(branches.reflect, bsdf->opacity);
    branches.diffuse = rgb_scale(branches.diffuse, bsdf->opacity);
    branches.transmit = rgb_mad(rgb_gray(1 - bsdf->opacity), bsdf->opacity, branches.transmit);
    branches.transmit_direction = chain->direction;
    return branches;
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
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_random *random)
{
    rsv_vec3 normal, wo = v3_neg(chain->direction);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    float chance = rsv_bsdf_specular_chance(bsdf, wo, normal, !chain->back);
    float u_lobe = chance * rsv_random_float(random), u1 = rsv_random_float(random);
    rsv_bsdf_event event =
        rsv_bsdf_draw_event(bsdf, wo, normal, !chain->back, u_lobe, u1, rsv_random_float(random));
    event.weight = rgb_scale(event.weight, chance * bsdf->opacity);
    if (event.pdf_solid_angle > 0) event.pdf_solid_angle /= chance;
    return event;
}

rsv_chain_move rsv_chain_step(const rsv_transport_scene *scene, rsv_chain *chain, bool transmit,
    rsv_vec3 direction, rsv_rgb weight)
{
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    rsv_vec3 leave = transmit ? v3_neg(point.geometric) : point.geometric;
    // an interpolated normal can send light through the surface: it is lost, as to the reference
    if (v3_dot(direction, leave) <= 0) return RSV_CHAIN_LOST;
    rsv_ray ray = { rsv_offset_origin(point.position, leave, point.extent), direction, INFINITY };
    rsv_hit hit;
    float spread = chain->spread, width = chain->width;
    uint32_t events = chain->events + 1, rays = chain->rays + 1;
    rsv_rgb throughput = rgb_mul(chain->weight, weight);
    if (!rsv_tracer_closest(scene->tracer, &ray, &hit)) {
        chain->direction = direction;
        chain->weight = throughput;
        chain->rays = rays;
        return RSV_CHAIN_LEFT_SCENE;
    }
    *chain = rsv_chain_begin(scene, direction, hit.triangle, hit.u, hit.v, hit.t);
    chain->weight = rgb_mul(chain->weight, throughput);
    chain->events = events;
    chain->rays = rays;
    chain->spread = spread;
    chain->width = width + spread * hit.t;
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
                rgb_add(gather.emission, rgb_mul(chain.weight, emission_towards(scene, &chain)));
        gather.chain = chain;
        rsv_bsdf_event event = rsv_chain_draw_event(scene, &chain, random);
        if (event.lobe == RSV_LOBE_NONE || chain.events >= RSV_CHAIN_MAX_EVENTS) return gather;
        if (event.lobe == RSV_LOBE_DIFFUSE) {
            gather.chain.weight = rgb_mul(chain.weight, event.weight);
            gather.end = survive_roulette(&gather.chain.weight, random) ? RSV_CHAIN_DIFFUSE
                                                                        : RSV_CHAIN_ABSORBED;
            return gather;
        }
        bool transmit = event.lobe == RSV_LOBE_TRANSMIT;
        rsv_chain_move move =
            rsv_chain_step(scene, &chain, transmit, event.direction, event.weight);
        if (move == RSV_CHAIN_LOST) return gather;
        gather.chain = chain;
        if (move == RSV_CHAIN_LEFT_SCENE) {
            gather.end = RSV_CHAIN_ESCAPED;
            return gather;
        }
        if (!survive_roulette(&chain.weight, random)) return gather;
    }
}
