#include "chain.h"

#include "elements.h"

static uint32_t chain_material(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    return scene->view->triangle_material[chain->triangle];
}

/// Moves to a surface at the end of a segment of length `t`; direction and medium are set.
static void arrive(const rsv_transport_scene *scene, rsv_chain *chain, uint32_t triangle, float u,
    float v, float t)
{
    chain->triangle = triangle;
    chain->u = u;
    chain->v = v;
    chain->width += chain->spread * t;
    const uint32_t *corner = scene->view->triangle[triangle];
    rsv_vec3 a = scene->view->position[corner[0]];
    rsv_vec3 normal = v3_cross(
        v3_sub(scene->view->position[corner[1]], a), v3_sub(scene->view->position[corner[2]], a));
    chain->back = v3_dot(normal, chain->direction) > 0;
    // what a body is made of is the same all over
    if (scene->bsdf[chain_material(scene, chain)].solid) {
        if (chain->back) rsv_medium_arrive_inside(&chain->medium, chain_material(scene, chain));
        if (!chain->settled) chain->start_ior = rsv_medium_ior(&chain->medium, scene->bsdf);
        chain->settled = true;
    }
    if (chain->medium.depth)
        chain->weight =
            rgb_mul(chain->weight, rsv_medium_transmittance(&chain->medium, scene->bsdf, t));
}

rsv_chain rsv_chain_begin(const rsv_transport_scene *scene, const rsv_medium *medium,
    rsv_vec3 direction, uint32_t triangle, float u, float v, float t)
{
    rsv_chain chain = {
        .direction = direction, .weight = rgb_gray(1), .start_ior = 1, .spread = RSV_GATHER_SPREAD
    };
    if (medium && medium->depth) {
        chain.medium = *medium;
        chain.start_ior = rsv_medium_ior(medium, scene->bsdf);
    }
    arrive(scene, &chain, triangle, u, v, t);
    return chain;
}

rsv_rgb rsv_chain_throughput(
    const rsv_transport_scene *scene, const rsv_chain *chain, const rsv_medium *medium)
{
    float ratio = chain->start_ior / rsv_medium_ior(medium, scene->bsdf);
    return rgb_scale(chain->weight, ratio * ratio);
}

rsv_medium rsv_chain_medium_beyond(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_medium medium = chain->medium;
    uint32_t material = chain_material(scene, chain);
    if (scene->bsdf[material].solid) rsv_medium_cross(&medium, material, chain->back);
    return medium;
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

static rsv_surface_point seen_point(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    return rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
}

/// The shading normal, or the geometric one for a silhouette seen under an interpolated normal that already turns away.
static rsv_vec3 facing_normal(const rsv_chain *chain, const rsv_surface_point *seen)
{
    return v3_dot(seen->normal, chain->direction) >= 0 ? seen->geometric : seen->normal;
}

void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *shading,
    rsv_vec3 *geometric)
{
    rsv_surface_point point = seen_point(scene, chain);
    *shading = facing_normal(chain, &point);
    *geometric = point.geometric;
}

static const rsv_bsdf *scattering_at(const rsv_transport_scene *scene, const rsv_chain *chain,
    const rsv_surface_point *seen, rsv_vec3 *normal, rsv_bsdf *storage)
{
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, storage);
    *normal = facing_normal(chain, seen);
    if (!bsdf->lambert)
        *normal = rsv_bsdf_specular_normal(*normal, seen->geometric, v3_neg(chain->direction));
    return bsdf;
}

const rsv_bsdf *rsv_chain_scattering(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *normal, rsv_bsdf *storage)
{
    rsv_surface_point seen = seen_point(scene, chain);
    return scattering_at(scene, chain, &seen, normal, storage);
}

rsv_bsdf_branches rsv_chain_branches_at(
    const rsv_transport_scene *scene, const rsv_chain *chain, const rsv_surface_point *seen)
{
    rsv_vec3 normal;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = scattering_at(scene, chain, seen, &normal, &storage);
    rsv_bsdf_branches branches =
        rsv_bsdf_evaluate_branches(bsdf, v3_neg(chain->direction), normal, !chain->back);
    if (bsdf->opacity >= 1) return branches;
    branches.reflect = rgb_scale(branches.reflect, bsdf->opacity);
    branches.diffuse = rgb_scale(branches.diffuse, bsdf->opacity);
    branches.transmit = rgb_mad(rgb_gray(1 - bsdf->opacity), bsdf->opacity, branches.transmit);
    branches.transmit_direction = chain->direction;
    return branches;
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
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_random *random)
{
    rsv_vec3 normal, wo = v3_neg(chain->direction);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_scattering(scene, chain, &normal, &storage);
    float u_lobe = rsv_random_float(random), u1 = rsv_random_float(random);
    rsv_bsdf_event event = rsv_bsdf_draw_specular(
        bsdf, wo, normal, !chain->back, u_lobe, u1, rsv_random_float(random));
    event.weight = rgb_scale(event.weight, bsdf->opacity);
    return event;
}

bool rsv_chain_depart(
    const rsv_surface_point *point, bool transmit, rsv_vec3 direction, rsv_ray *ray)
{
    rsv_vec3 leave = transmit ? v3_neg(point->geometric) : point->geometric;
    *ray =
        (rsv_ray){ rsv_offset_origin(point->position, leave, point->extent), direction, INFINITY };
    // an interpolated normal can send light through the surface: it is lost, as to the reference
    return v3_dot(direction, leave) > 0;
}

void rsv_chain_set_out(const rsv_transport_scene *scene, rsv_chain *chain, bool transmit,
    rsv_vec3 direction, rsv_rgb weight)
{
    if (transmit) chain->medium = rsv_chain_medium_beyond(scene, chain);
    chain->direction = direction;
    chain->weight = rgb_mul(chain->weight, weight);
    chain->rays++;
}

void rsv_chain_arrive(const rsv_transport_scene *scene, rsv_chain *chain, const rsv_hit *hit)
{
    chain->events++;
    arrive(scene, chain, hit->triangle, hit->u, hit->v, hit->t);
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
