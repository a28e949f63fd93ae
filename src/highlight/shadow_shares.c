#include "shadow_shares.h"

#include "../core/core.h"
#include "../sources/punctual_light.h"
#include "../trace/passage.h"
#include "highlights_internal.h"

#define UNKNOWN 255
#define WHOLE 254

/// A node as a receiver.
typedef struct node_point {
    rsv_surface_point point;
    rsv_vec3 origin;
    uint32_t seed;
} node_point;

static node_point place_node(const rsv_elements *elements, uint32_t node, uint32_t seed)
{
    uint32_t face;
    float u, v;
    rsv_elements_place_node(elements, node, &face, &u, &v);
    node_point p = { .seed = rsv_hash2(seed, rsv_elements_draw_of(elements, node)) };
    p.point = rsv_surface_point_at(
        elements->scene, elements->face_triangle[face], u, v, elements->face_back[face]);
    p.origin = rsv_moved_off(p.point.position, p.point.geometric, p.point.extent);
    return p;
}

/// A place on a lamp of the group, lamps by their power; the same places for all sums of weights.
static rsv_vec3 place_on_group(
    const rsv_highlights *h, uint32_t group, float pick, float x, float y, uint32_t *emitter)
{
    uint32_t node = h->lamps.root[group];
    while (h->lamps.node[node].right) {
        uint32_t right = h->lamps.node[node].right;
        float a =
            sqrtf(f_max(h->lamps.node[node + 1].facing[0] + h->lamps.node[node + 1].facing[1] +
                            h->lamps.node[node + 1].facing[2],
                0));
        float b = sqrtf(f_max(h->lamps.node[right].facing[0] + h->lamps.node[right].facing[1] +
                                  h->lamps.node[right].facing[2],
            0));
        float share = a + b > 0 ? a / (a + b) : 0.5f;
        bool left = pick < share;
        pick = left ? pick / share : (pick - share) / (1 - share);
        node = left ? node + 1 : right;
    }
    const rsv_lamp *lamp = &h->lamps.lamp[h->lamps.node[node].lamp];
    float u = x, v = y;
    *emitter = lamp->emitter;
    if (lamp->count == 3) rsv_square_to_triangle(x, y, &u, &v);
    rsv_vec3 a = v3_sub(lamp->corner[1], lamp->corner[0]);
    rsv_vec3 b = v3_sub(lamp->corner[lamp->count - 1], lamp->corner[0]);
    return v3_mad(v3_mad(lamp->corner[0], u, a), v, b);
}

/// A shadow ray from a node. @return weight of what it asks for; 0 = nothing arrives that way
static float ask_group(const rsv_highlights *h, const node_point *p, uint32_t group, float pick,
    float x, float y, rsv_ray *ray)
{
    rsv_light_sample to = { 0 };
    if (h->lamps.root[group] == RSV_NONE) return 0;
    rsv_vec3 place = place_on_group(h, group, pick, x, y, &to.emitter);
    rsv_vec3 way = v3_sub(place, p->point.position);
    to.distance = v3_length(way);
    if (!(to.distance > 0)) return 0;
    to.direction = v3_scale(way, 1 / to.distance);
    const rsv_emitter *e = &h->lights->emitter[to.emitter];
    float shown = -v3_dot(e->normal, to.direction);
    if (e->double_sided) shown = fabsf(shown);
    if (!(shown > 0) || !rsv_surface_faces(&p->point, to.direction)) return 0;
    *ray = rsv_shadow_ray(h->lights, &to, p->point.position, p->origin);
    return shown / (to.distance * to.distance);
}

static float ask(
    const rsv_highlights *h, const node_point *p, uint32_t source, uint32_t k, rsv_ray *ray)
{
    rsv_highlight_source s = rsv_highlights_source(h, source);
    float x, y, pick = rsv_sobol_1d(k, rsv_hash3(p->seed, source, 1)), distance;
    rsv_rgb irradiance;
    rsv_punctual_sample to;
    rsv_sobol_2d(k, rsv_hash3(p->seed, source, 0), &x, &y);
    switch (s.kind) {
    case RSV_HIGHLIGHT_GROUP:
        return ask_group(h, p, s.index, pick, x, y, ray);
    case RSV_HIGHLIGHT_PUNCTUAL:
        to.light = &h->lights->scene->light[s.index];
        if (!rsv_punctual_irradiance(
                to.light, p->point.position, &to.direction, &distance, &irradiance) ||
            !rsv_surface_faces(&p->point, to.direction))
            return 0;
        to.distance = distance;
        *ray = rsv_punctual_ray(&to, p->origin);
        return 1;
    case RSV_HIGHLIGHT_SUN:
        *ray = rsv_ray_to(
            p->origin, rsv_sun_sample(&h->lights->environment->sun[s.index], x, y), INFINITY);
        return rsv_surface_faces(&p->point, ray->direction) ? 1 : 0;
    default: {
        rsv_vec3 t, b, v = rsv_square_to_cosine_hemisphere(x, y);
        v3_frame(p->point.normal, &t, &b);
        rsv_vec3 way = v3_mad(v3_mad(v3_scale(t, v.x), v.y, b), v.z, p->point.normal);
        *ray = rsv_ray_to(p->origin, way, INFINITY);
        if (!rsv_surface_faces(&p->point, way)) return 0;
        return rgb_luminance(rsv_sky_map_mean(&h->sky, way, 0));
    }
    }
}

static uint8_t share_of(const rsv_highlights *h, const rsv_tracer *tracer, const node_point *p,
    uint32_t source, uint32_t rays)
{
    float open = 0, arrived = 0;
    for (uint32_t k = 0; k < rays; k++) {
        rsv_ray ray;
        float weight = ask(h, p, source, k, &ray);
        if (!(weight > 0)) continue;
        open += weight;
        arrived += weight * rsv_tracer_passed(tracer, &ray);
    }
    return open > 0 ? (uint8_t)lrintf(f_min(arrived / open, 1) * WHOLE) : UNKNOWN;
}

rsv_status rsv_shadow_shares_create(const rsv_highlights *h, const rsv_tracer *tracer,
    const rsv_elements *elements, uint32_t rays, uint32_t seed, rsv_shadow_shares **result)
{
    rsv_context *context = h->context;
    rsv_shadow_shares *s = rsv_alloc(context, 1, sizeof *s);
    *result = NULL;
    if (!s) return RSV_ERROR_MEMORY;
    s->context = context;
    s->source_count = rsv_highlights_source_count(h);
    s->node_count = elements->node_count;
    s->share = rsv_alloc(context, s->node_count * s->source_count + 1, 1);
    if (!s->share) {
        rsv_free(context, s);
        return RSV_ERROR_MEMORY;
    }
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context))
    for (size_t n = 0; n < s->node_count; n++) {
        node_point p = place_node(elements, (uint32_t)n, seed);
        for (uint32_t k = 0; k < s->source_count; k++)
            s->share[n * s->source_count + k] = share_of(h, tracer, &p, k, rays);
    }
    *result = s;
    return RSV_OK;
}

void rsv_shadow_shares_destroy(rsv_shadow_shares *s)
{
    if (!s) return;
    rsv_context *context = s->context;
    rsv_free(context, s->share);
    rsv_free(context, s);
}

float rsv_shadow_share_at(const rsv_shadow_shares *s, const uint32_t node[3], const float weight[3],
    uint32_t source, bool *certain)
{
    float sum = 0, known = 0;
    uint32_t lit = 0, dark = 0, unknown = 0;
    *certain = false;
    if (source >= s->source_count) return -1;
    for (int k = 0; k < 3; k++) {
        uint8_t share = s->share[(size_t)node[k] * s->source_count + source];
        lit += share == WHOLE;
        dark += share == 0;
        unknown += share == UNKNOWN;
        if (share == UNKNOWN) continue;
        sum += weight[k] * (float)share / WHOLE;
        known += weight[k];
    }
    *certain = unknown == 0 && (lit == 3 || dark == 3);
    return known > 0 ? sum / known : -1;
}
