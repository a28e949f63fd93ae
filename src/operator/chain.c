#include "chain.h"

#include "elements.h"

rsv_chain rsv_chain_begin(const rsv_transport_scene *scene, rsv_vec3 direction, uint32_t triangle,
    float u, float v, float t)
{
    rsv_chain chain = { direction, rgb_gray(1), triangle, u, v, false, 0, 0 };
    const uint32_t *corner = scene->view->triangle[triangle];
    rsv_vec3 a = scene->view->position[corner[0]];
    rsv_vec3 normal = v3_cross(
        v3_sub(scene->view->position[corner[1]], a), v3_sub(scene->view->position[corner[2]], a));
    chain.back = v3_dot(normal, direction) > 0;
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[triangle]];
    // Arriving at the inside of a body's surface means the segment ran through the body.
    if (chain.back && bsdf->solid && !rgb_is_black(bsdf->absorption))
        chain.weight = rgb(expf(-bsdf->absorption.r * t), expf(-bsdf->absorption.g * t),
            expf(-bsdf->absorption.b * t));
    return chain;
}

void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *shading,
    rsv_vec3 *geometric)
{
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    *shading = point.normal;
    *geometric = point.geometric;
    // a silhouette seen under an interpolated normal that already turns away
    if (v3_dot(*shading, chain->direction) >= 0) *shading = *geometric;
}

rsv_bsdf_branches rsv_chain_branches(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    rsv_vec3 shading, geometric;
    rsv_chain_normals(scene, chain, &shading, &geometric);
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[chain->triangle]];
    return rsv_bsdf_evaluate_branches(bsdf, v3_neg(chain->direction), shading, !chain->back);
}

/// Keeps a specular direction on the side it belongs to: interpolated normals can tilt it through the
/// surface, where it would be lost.
static rsv_vec3 keep_side(rsv_vec3 direction, rsv_vec3 geometric, bool transmit)
{
    float side = v3_dot(direction, geometric), wanted = transmit ? -1.0f : 1.0f;
    if (side * wanted > 0) return direction;
    return v3_normalize(v3_mad(direction, wanted * 1e-3f - side, geometric));
}

bool rsv_chain_step(const rsv_transport_scene *scene, rsv_chain *chain, bool transmit,
    rsv_vec3 direction, rsv_rgb weight)
{
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    rsv_vec3 leave = transmit ? v3_neg(point.geometric) : point.geometric;
    direction = keep_side(direction, point.geometric, transmit);
    rsv_ray ray = { rsv_offset_origin(point.position, leave, point.extent), direction, INFINITY };
    rsv_hit hit;
    uint32_t events = chain->events + 1, rays = chain->rays + 1;
    rsv_rgb throughput = rgb_mul(chain->weight, weight);
    if (!rsv_tracer_closest(scene->tracer, &ray, &hit)) {
        chain->direction = direction;
        chain->weight = throughput;
        chain->rays = rays;
        return false;
    }
    *chain = rsv_chain_begin(scene, direction, hit.triangle, hit.u, hit.v, hit.t);
    chain->weight = rgb_mul(chain->weight, throughput);
    chain->events = events;
    chain->rays = rays;
    return true;
}

static bool shows_emission(const rsv_transport_scene *scene, const rsv_chain *chain)
{
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[chain->triangle]];
    return bsdf->emissive && (!chain->back || bsdf->double_sided);
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
        if (shows_emission(scene, &chain) && filter(user, chain.triangle, chain.events)) {
            const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[chain.triangle]];
            gather.emission = rgb_add(gather.emission, rgb_mul(chain.weight, bsdf->emission));
        }
        rsv_bsdf_branches branches = rsv_chain_branches(scene, &chain);
        float r = rgb_max(branches.reflect), t = rgb_max(branches.transmit);
        float d = rgb_max(branches.diffuse), sum = r + t + d;
        // Each branch is taken with its own weight as probability; the rest of 1 is absorption. Where
        // colours make the weights add up to more than 1, they are brought down to it.
        float norm = f_max(sum, 1), choice = rsv_random_float(random) * norm;
        gather.chain = chain;
        if (choice >= sum || chain.events >= RSV_CHAIN_MAX_EVENTS) return gather;
        bool diffuse = choice < d, transmit = choice >= d + r;
        rsv_rgb branch = diffuse    ? branches.diffuse
                         : transmit ? branches.transmit
                                    : branches.reflect;
        float probability = (diffuse ? d : transmit ? t : r) / norm;
        rsv_rgb weight = rgb_scale(branch, 1 / probability);
        if (diffuse) {
            gather.chain.weight = rgb_mul(chain.weight, weight);
            gather.end = survive_roulette(&gather.chain.weight, random) ? RSV_CHAIN_DIFFUSE
                                                                        : RSV_CHAIN_ABSORBED;
            return gather;
        }
        rsv_vec3 direction = transmit ? branches.transmit_direction : branches.reflect_direction;
        if (!rsv_chain_step(scene, &chain, transmit, direction, weight)) {
            gather.chain = chain;
            gather.end = RSV_CHAIN_ESCAPED;
            return gather;
        }
        if (!survive_roulette(&chain.weight, random)) {
            gather.chain.rays = chain.rays;
            return gather;
        }
    }
}
