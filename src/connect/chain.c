#include "connect_internal.h"

#define STEP 1e-6 ///< of differences: radians, or of the scene's radius

uint8_t rsv_chain_kind_of(const rsv_transport_scene *scene, uint32_t triangle, bool transmit)
{
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[triangle]];
    if (!transmit) return RSV_CHAIN_MIRRORS;
    bool bends = bsdf->solid && !bsdf->straight && bsdf->alpha == 0 && bsdf->opacity >= 1;
    return bends ? RSV_CHAIN_REFRACTS : RSV_CHAIN_PASSES;
}

static void frame_of(rsv_double3 axis, rsv_double3 *t, rsv_double3 *b)
{
    rsv_vec3 across, up;
    v3_frame(d3_to_float(axis), &across, &up);
    *t = d3_from(across);
    *t = d3_normalize(d3_mad(*t, -d3_dot(*t, axis), axis));
    *b = d3_cross(axis, *t);
}

rsv_double_ray rsv_chain_start(const rsv_chain_seed *seed, double u, double v)
{
    rsv_double3 t, b;
    rsv_double_ray ray = seed->ray;
    frame_of(ray.direction, &t, &b);
    if (seed->distant)
        ray.origin = d3_mad(d3_mad(ray.origin, u, t), v, b);
    else
        ray.direction = d3_normalize(d3_mad(d3_mad(ray.direction, u, t), v, b));
    return ray;
}

/// Normal of a triangle at a place of its plane, on the side that light arrives from, as specular paths see it.
static rsv_double3 normal_at(const rsv_scene_view *view, const rsv_chain_event *event,
    rsv_double3 geometric, const rsv_chain_hit *hit, rsv_double3 direction)
{
    const uint32_t *corner = view->triangle[event->triangle];
    rsv_double3 n = d3_scale(d3_from(view->normal[corner[0]]), 1 - hit->u - hit->v);
    n = d3_mad(n, hit->u, d3_from(view->normal[corner[1]]));
    n = d3_normalize(d3_mad(n, hit->v, d3_from(view->normal[corner[2]])));
    if (d3_dot(n, geometric) <= 0) n = geometric;
    if (event->back) n = d3_scale(n, -1), geometric = d3_scale(geometric, -1);
    double cos = d3_dot(n, direction);
    if (cos >= 0) return geometric;
    rsv_double3 mirrored = d3_mad(direction, -2 * cos, n);
    return d3_dot(mirrored, geometric) > 0 ? n : geometric;
}

/// Takes the ray to the plane of the event's triangle. False if it runs away from it.
static bool meet_plane(const rsv_scene_view *view, uint32_t triangle, rsv_double_ray *ray,
    rsv_double3 *geometric, rsv_chain_hit *hit)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]];
    rsv_double3 e1 = d3_between(a, view->position[corner[1]]),
                e2 = d3_between(a, view->position[corner[2]]), n = d3_cross(e1, e2);
    double square = d3_dot(n, n), cos = d3_dot(n, ray->direction);
    if (!(square > 0) || cos == 0) return false;
    double t = d3_dot(n, d3_sub(d3_from(a), ray->origin)) / cos;
    if (!(t > 0)) return false;
    ray->origin = hit->position = d3_mad(ray->origin, t, ray->direction);
    rsv_double3 p = d3_sub(ray->origin, d3_from(a));
    hit->u = d3_dot(n, d3_cross(p, e2)) / square;
    hit->v = d3_dot(n, d3_cross(e1, p)) / square;
    *geometric = d3_scale(n, 1 / sqrt(square));
    return true;
}

/// @param n on the side that the direction comes from @param eta the far side's ior over that of this one
static bool refract(rsv_double3 *direction, rsv_double3 n, double eta)
{
    double cos = -d3_dot(n, *direction), square = 1 - (1 - cos * cos) / (eta * eta);
    if (!(square > 0)) return false;
    rsv_double3 bent = d3_scale(*direction, 1 / eta);
    *direction = d3_normalize(d3_mad(bent, cos / eta - sqrt(square), n));
    return true;
}

static double ior_of(const rsv_bsdf *bsdf, rsv_channel channel)
{
    bool apart = channel != RSV_CHANNEL_ALL && rsv_bsdf_disperses(bsdf);
    return (double)(apart ? rsv_bsdf_in_channel(bsdf, channel).ior : bsdf->ior);
}

bool rsv_chain_follow(const rsv_connections *c, const rsv_chain *chain,
    const rsv_chain_event *event, rsv_double_ray *ray, rsv_chain_hit *hit)
{
    const rsv_scene_view *view = c->scene.view;
    for (uint32_t k = 0; k < chain->count; k++) {
        rsv_double3 geometric;
        if (!meet_plane(view, event[k].triangle, ray, &geometric, &hit[k])) return false;
        rsv_double3 n = normal_at(view, &event[k], geometric, &hit[k], ray->direction);
        double cos = d3_dot(n, ray->direction);
        if (cos >= 0) return false;
        if (event[k].kind == RSV_CHAIN_MIRRORS)
            ray->direction = d3_normalize(d3_mad(ray->direction, -2 * cos, n));
        if (event[k].kind == RSV_CHAIN_REFRACTS) {
            double ior =
                ior_of(&c->scene.bsdf[view->triangle_material[event[k].triangle]], chain->channel);
            if (!refract(&ray->direction, n, event[k].back ? 1 / ior : ior)) return false;
        }
        hit[k].direction = ray->direction;
    }
    return true;
}

bool rsv_chain_differentiate(const rsv_connections *c, const rsv_chain *chain,
    const rsv_chain_event *event, const double at[2], rsv_double_ray end[3])
{
    rsv_chain_hit hit[RSV_CHAIN_EVENTS];
    double h = chain->seed.distant ? STEP * c->radius : STEP;
    for (int k = 0; k < 3; k++) {
        end[k] = rsv_chain_start(&chain->seed, at[0] + (k == 1 ? h : 0), at[1] + (k == 2 ? h : 0));
        if (!rsv_chain_follow(c, chain, event, &end[k], hit)) return false;
    }
    for (int k = 1; k < 3; k++) {
        end[k].origin = d3_scale(d3_sub(end[k].origin, end[0].origin), 1 / h);
        end[k].direction = d3_scale(d3_sub(end[k].direction, end[0].direction), 1 / h);
    }
    return true;
}

double rsv_chain_extent(const rsv_connections *c, const rsv_chain_seed *seed, uint32_t triangle)
{
    const rsv_scene_view *view = c->scene.view;
    double most = 0;
    for (int k = 0; k < 3; k++) {
        rsv_double3 corner = d3_from(view->position[view->triangle[triangle][k]]);
        rsv_double3 way = d3_sub(corner, seed->ray.origin);
        double along = d3_dot(way, seed->ray.direction);
        double across = d3_length(d3_mad(way, -along, seed->ray.direction));
        if (!seed->distant && !(along > 0)) return INFINITY;
        most = fmax(most, seed->distant ? across : across / along);
    }
    return most;
}
