#include "connect_internal.h"

#include "../core/core.h"

#include <string.h>

#define OPENING_PARTS 16 ///< places of a luminaire with a luminous opening
#define MANY_OPENINGS 64 ///< such luminaires, from which on one place stands for each
#define STEPS 24         ///< of Newton's method
#define HALVINGS 6       ///< of a step
#define CONVERGED 1e-10  ///< of the scene's radius
#define SAME 1e-7        ///< likewise: paths that are one
#define RETRACES 6       ///< chains beside that are tried
#define INSIDE 1e-9      ///< by which barycentric coordinates may be negative
#define CLEAR 1e-4f      ///< of the last segment that need not be free

/// The problem to solve: a ray through a chain that passes a point.
typedef struct aim {
    const rsv_connections *c;
    const rsv_connect_source *source;
    rsv_chain chain; ///< that is tried
    rsv_chain_event event[RSV_CHAIN_EVENTS];
    rsv_chain_hit hit[RSV_CHAIN_EVENTS];
    rsv_double3 point;
    double at[2];    ///< u, v relative to the seed
    double area;     ///< at the point per u and v
    double distance; ///< of the last segment
} aim;

/// Which path a connection is.
typedef struct route {
    rsv_double3 first, last;
    uint32_t source, count;
    rsv_channel channel;
} route;

// ---- one chain ----------------------------------------------------------------------------------

/// Where the ray passes the point: `offset` from it, along two directions perpendicular to the ray.
/// @param slope its derivatives @return the distance along the ray; 0 or less if it does not get there
static double pass_by(
    const rsv_double_ray end[3], rsv_double3 point, double offset[2], double slope[2][2])
{
    rsv_double3 way = d3_sub(point, end[0].origin), side[2];
    rsv_vec3 t, b;
    double s = d3_dot(way, end[0].direction);
    v3_frame(d3_to_float(end[0].direction), &t, &b);
    side[0] = d3_from(t);
    side[0] = d3_normalize(d3_mad(side[0], -d3_dot(side[0], end[0].direction), end[0].direction));
    side[1] = d3_cross(end[0].direction, side[0]);
    for (int i = 0; i < 2; i++) {
        offset[i] = -d3_dot(way, side[i]);
        for (int j = 0; j < 2; j++)
            slope[i][j] = d3_dot(side[i], d3_mad(end[1 + j].origin, s, end[1 + j].direction));
    }
    return s;
}

static double determinant(const double m[2][2]) { return m[0][0] * m[1][1] - m[0][1] * m[1][0]; }

/// -slope^-1 offset; false where rays meet at the point.
static bool newton_step(const double offset[2], const double slope[2][2], double step[2])
{
    double det = determinant(slope);
    if (!(fabs(det) > 0)) return false;
    step[0] = (slope[0][1] * offset[1] - slope[1][1] * offset[0]) / det;
    step[1] = (slope[1][0] * offset[0] - slope[0][0] * offset[1]) / det;
    return isfinite(step[0]) && isfinite(step[1]);
}

/// Whether a chain may lead to the point, from its derivatives alone: rays up to `extent` from the seed's pass within
/// the norm of the slope times that.
static bool may_reach(const rsv_chain_beam *beam, rsv_vec3 point)
{
    if (!(beam->extent < INFINITY)) return true;
    rsv_vec3 way = v3_sub(point, beam->origin);
    float s = v3_dot(way, beam->direction), square = v3_dot(way, way);
    rsv_vec3 u = v3_mad(beam->origin_u, s, beam->direction_u);
    rsv_vec3 v = v3_mad(beam->origin_v, s, beam->direction_v);
    float reach = beam->extent * beam->extent * (v3_dot(u, u) + v3_dot(v, v));
    return square - s * s < reach && (s > 0 || square < reach);
}

/// Solves the chain for the ray by the point.
static bool solve(aim *a)
{
    double offset[2] = { 0, 0 }, slope[2][2] = { { 0 } }, step[2] = { 0, 0 },
           from[2] = { a->at[0], a->at[1] };
    double share = 1, best = INFINITY;
    int halved = 0;
    for (int k = 0; k < STEPS; k++) {
        rsv_double_ray end[3];
        bool there = rsv_chain_differentiate(a->c, &a->chain, a->event, a->at, end);
        if (there) a->distance = pass_by(end, a->point, offset, slope);
        double miss = there ? sqrt(offset[0] * offset[0] + offset[1] * offset[1]) : INFINITY;
        if (miss < CONVERGED * a->c->radius) {
            a->area = fabs(determinant(slope));
            rsv_double_ray ray = rsv_chain_start(&a->chain.seed, a->at[0], a->at[1]);
            return a->distance > 0 && a->area > 0 &&
                   rsv_chain_follow(a->c, &a->chain, a->event, &ray, a->hit);
        }
        if (!(miss < best)) {
            if (++halved > HALVINGS) return false;
            share *= 0.5;
        } else {
            best = miss, share = 1, halved = 0;
            from[0] = a->at[0], from[1] = a->at[1];
            if (!newton_step(offset, slope, step)) return false;
        }
        for (int i = 0; i < 2; i++)
            a->at[i] = from[i] + share * step[i];
    }
    return false;
}

static bool is_inside(const aim *a)
{
    for (uint32_t k = 0; k < a->chain.count; k++) {
        const rsv_chain_hit *h = &a->hit[k];
        if (h->u < -INSIDE || h->v < -INSIDE || h->u + h->v > 1 + INSIDE) return false;
    }
    return true;
}

/// Puts the triangles that a real ray meets, by the same kinds of events, in place of the chain's. False if it cannot
/// go so.
static bool retrace(aim *a)
{
    const rsv_transport_scene *scene = &a->c->scene;
    rsv_specular_path path;
    const rsv_double_ray ray = rsv_chain_start(&a->chain.seed, a->at[0], a->at[1]);
    if (!rsv_chain_set_out(a->c, a->source, &ray, a->chain.channel, &path)) return false;
    bool other = false;
    for (uint32_t k = 0; k < a->chain.count; k++) {
        rsv_chain_event *event = &a->event[k];
        bool transmit = event->kind != RSV_CHAIN_MIRRORS;
        other = other || event->triangle != path.triangle;
        uint8_t kind = rsv_chain_kind_of(scene, path.triangle, transmit);
        if (kind != event->kind) return false;
        *event = (rsv_chain_event){ path.triangle, kind, path.back };
        if (k + 1 == a->chain.count) break;
        rsv_bsdf_branches lobe = rsv_specular_branches(scene, &path);
        rsv_rgb weight = transmit ? lobe.transmit : lobe.reflect;
        rsv_vec3 direction = transmit ? lobe.transmit_direction : lobe.reflect_direction;
        if (rgb_is_black(weight) ||
            rsv_specular_step(scene, &path, transmit, direction, weight) != RSV_SPECULAR_MOVED)
            return false;
    }
    return other;
}

// ---- transmitted light ---------------------------------------------------------------------------

/// Whether a real path has come to where the chain's ray meets its surface.
static bool is_at(const aim *a, const rsv_specular_path *path, uint32_t k)
{
    if (path->triangle == a->event[k].triangle) return true;
    const rsv_transport_scene *scene = &a->c->scene;
    rsv_surface_point p =
        rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back);
    double off = d3_length(d3_sub(d3_from(p.position), a->hit[k].position));
    uint32_t material = scene->view->triangle_material[a->event[k].triangle];
    return rsv_specular_material(scene, path) == material && path->back == a->event[k].back &&
           off < 1e-5 * fmax(a->c->radius, (double)p.extent);
}

/// The last segment, if nothing is in its way.
static bool arrive(const aim *a, rsv_specular_path *path, bool transmit, rsv_rgb weight)
{
    const rsv_transport_scene *scene = &a->c->scene;
    rsv_vec3 direction = d3_to_float(a->hit[a->chain.count - 1].direction);
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back);
    rsv_ray ray;
    if (!rsv_specular_depart(&point, transmit, direction, &ray)) return false;
    ray.t_max = (float)a->distance * (1 - CLEAR);
    if (rsv_tracer_occluded(scene->tracer, &ray)) return false;
    rsv_specular_set_out(scene, path, transmit, direction, weight);
    path->weight = rgb_mul(
        path->weight, rsv_medium_transmittance(&path->medium, scene->bsdf, (float)a->distance));
    return true;
}

/// Fraction of the light that reaches the point, without light that only passes blended surfaces, which shadow rays
/// find.
static rsv_rgb passed(const aim *a)
{
    const rsv_transport_scene *scene = &a->c->scene;
    rsv_specular_path path;
    const rsv_double_ray ray = rsv_chain_start(&a->chain.seed, a->at[0], a->at[1]);
    if (!rsv_chain_set_out(a->c, a->source, &ray, a->chain.channel, &path)) return rgb_gray(0);
    float straight = 1;
    for (uint32_t k = 0; k < a->chain.count; k++) {
        if (!is_at(a, &path, k)) return rgb_gray(0);
        bool transmit = a->event[k].kind != RSV_CHAIN_MIRRORS, last = k + 1 == a->chain.count;
        rsv_bsdf storage;
        straight *= transmit ? 1 - rsv_specular_bsdf(scene, &path, &storage)->opacity : 0;
        rsv_bsdf_branches lobe = rsv_specular_branches(scene, &path);
        rsv_rgb weight = transmit ? lobe.transmit : lobe.reflect;
        rsv_vec3 direction = d3_to_float(a->hit[k].direction);
        if (last ? !arrive(a, &path, transmit, weight)
                 : rsv_specular_step(scene, &path, transmit, direction, weight) !=
                       RSV_SPECULAR_MOVED)
            return rgb_gray(0);
    }
    return rgb_sub(path.weight, rgb_gray(straight));
}

/// Irradiance of the source's light per u and v, before any surface.
static rsv_rgb emitted(const aim *a)
{
    const rsv_punctual_light *light = a->source->light;
    double density = 1 / a->area;
    if (!a->chain.seed.distant) {
        rsv_double_ray ray = rsv_chain_start(&a->chain.seed, a->at[0], a->at[1]);
        double square = 1 + a->at[0] * a->at[0] + a->at[1] * a->at[1];
        density *=
            rsv_punctual_share(a->c->scene.view, light, d3_to_float(d3_scale(ray.direction, -1))) /
            (square * sqrt(square));
    }
    return rgb_scale(light->intensity, (float)(density * (double)a->source->share));
}

static rsv_rgb in_channel(rsv_rgb light, rsv_channel channel)
{
    if (channel == RSV_CHANNEL_ALL) return light;
    return rgb_scale(rgb_mul(light, rsv_channel_weight(channel)), 1.0f / 3);
}

/// Finds the ray through the point, of this chain or a neighbouring one. @param way out
static bool find(aim *a, route *way)
{
    for (int k = 0; k < RETRACES; k++) {
        if (!solve(a)) return false;
        if (is_inside(a)) {
            const rsv_chain_hit *last = &a->hit[a->chain.count - 1];
            way->first = a->hit[0].position, way->last = last->position;
            way->source = a->chain.source, way->count = a->chain.count;
            way->channel = a->chain.channel;
            return true;
        }
        if (!retrace(a)) return false;
    }
    return false;
}

// ---- all of them --------------------------------------------------------------------------------

static bool is_same(const route *a, const route *b, double radius)
{
    return a->source == b->source && a->count == b->count && a->channel == b->channel &&
           d3_length(d3_sub(a->first, b->first)) < SAME * radius &&
           d3_length(d3_sub(a->last, b->last)) < SAME * radius;
}

static bool is_found(const route *found, size_t count, const route *new, double radius)
{
    for (size_t k = 0; k < count; k++)
        if (is_same(&found[k], new, radius)) return true;
    return false;
}

static bool is_straight(const aim *a)
{
    for (uint32_t k = 0; k < a->chain.count; k++)
        if (a->event[k].kind != RSV_CHAIN_PASSES) return false;
    return true;
}

/// Routes of one place so far, and their light.
typedef struct routes {
    route taken[RSV_MOST_CONNECTIONS];
    rsv_connection *found;
    size_t count;
} routes;

/// Tries a chain, and adds its light unless it was found before.
static void connect_chain(const rsv_chain_list *list, size_t index, aim *a, routes *all)
{
    route *taken = &all->taken[all->count];
    a->chain = list->chain[index];
    a->source = &a->c->source[a->chain.source];
    a->at[0] = a->at[1] = 0;
    memcpy(a->event, list->event + a->chain.first, a->chain.count * sizeof *a->event);
    if (!find(a, taken) || is_found(all->taken, all->count, taken, a->c->radius)) return;
    rsv_vec3 way = d3_to_float(a->hit[a->chain.count - 1].direction);
    rsv_rgb light = in_channel(rgb_mul(emitted(a), passed(a)), a->chain.channel);
    if (!(rgb_max(light) > 0)) return;
    all->found[all->count++] = (rsv_connection){ v3_neg(way), light, is_straight(a) };
}

size_t rsv_connect(
    const rsv_connections *c, rsv_vec3 point, rsv_connection found[RSV_MOST_CONNECTIONS])
{
    routes all = { .found = found, .count = 0 };
    aim a = { .c = c, .point = d3_from(point) };
    for (size_t l = 0; l < c->source_count; l++)
        for (size_t k = 0; k < c->list[l].count && all.count < RSV_MOST_CONNECTIONS; k++)
            if (may_reach(&c->list[l].beam[k], point)) connect_chain(&c->list[l], k, &a, &all);
    return all.count;
}

size_t rsv_connections_chain_count(const rsv_connections *c)
{
    size_t sum = 0;
    for (size_t k = 0; k < c->source_count; k++)
        sum += c->list[k].count;
    return sum;
}

rsv_rgb rsv_connected_irradiance(
    const rsv_connections *c, rsv_vec3 point, rsv_vec3 normal, bool turned)
{
    rsv_rgb sum = rgb_gray(0);
    if (!c) return sum;
    rsv_connection found[RSV_MOST_CONNECTIONS];
    size_t count = rsv_connect(c, point, found);
    for (size_t k = 0; k < count; k++)
        if (!turned || !found[k].straight)
            sum = rgb_mad(sum, f_max(v3_dot(found[k].towards, normal), 0), found[k].irradiance);
    return sum;
}

// ---- sources ------------------------------------------------------------------------------------

static void add_source(
    rsv_connections *c, const rsv_punctual_light *light, uint32_t part, uint32_t parts)
{
    rsv_connect_source *s = &c->source[c->source_count++];
    *s = (rsv_connect_source){ .light = light, .share = 1 / (float)parts };
    float u = parts > 1 ? ((float)part + 0.5f) / (float)parts : 0.5f;
    s->place = rsv_punctual_place_by(light, u, 0);
    if (rsv_punctual_is_distant(light)) {
        const rsv_scene_view *view = c->scene.view;
        rsv_vec3 centre = v3_scale(v3_add(view->bounds_min, view->bounds_max), 0.5f);
        s->place = v3_mad(centre, -2 * (float)c->radius, light->direction);
    } else {
        s->medium = rsv_medium_above(&c->scene.media, s->place, v3(0, 1, 0));
    }
}

static rsv_status list_sources(rsv_connections *c)
{
    const rsv_lights *lights = c->lights;
    size_t extended = 0;
    for (size_t k = 0; k < lights->punctual_count; k++)
        extended += rsv_punctual_is_extended(&lights->scene->light[lights->punctual[k]]);
    uint32_t parts = extended < MANY_OPENINGS ? OPENING_PARTS : 1;
    size_t most = lights->punctual_count + extended * parts;
    c->source = rsv_alloc(c->context, most, sizeof *c->source);
    c->list = rsv_alloc(c->context, most, sizeof *c->list);
    if (!c->source || !c->list) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < lights->punctual_count; k++) {
        const rsv_punctual_light *light = &lights->scene->light[lights->punctual[k]];
        uint32_t count = rsv_punctual_is_extended(light) ? parts : 1;
        for (uint32_t part = 0; part < count && !rgb_is_black(light->intensity); part++)
            add_source(c, light, part, count);
    }
    return RSV_OK;
}

rsv_status rsv_connections_create(
    const rsv_transport_scene *scene, const rsv_lights *lights, rsv_connections **connections)
{
    rsv_status status;
    const rsv_scene_view *view = scene->view;
    *connections = NULL;
    if (!lights->punctual_count || view->fog || !view->triangle_count) return RSV_OK;
    rsv_connections *c = rsv_alloc(lights->context, 1, sizeof *c);
    if (!c) return RSV_ERROR_MEMORY;
    *c = (rsv_connections){ .context = lights->context, .scene = *scene, .lights = lights };
    c->radius = 0.5 * (double)v3_length(v3_sub(view->bounds_max, view->bounds_min));
    for (size_t k = 0; k < view->material_count; k++)
        c->disperses = c->disperses || rsv_bsdf_disperses(&scene->bsdf[k]);
    RSV_TRY(list_sources(c));
    RSV_TRY(rsv_chains_find(c));
    if (rsv_connections_chain_count(c)) {
        *connections = c;
        c = NULL;
    }
cleanup:
    rsv_connections_destroy(c);
    return status;
}

void rsv_connections_destroy(rsv_connections *c)
{
    if (!c) return;
    for (size_t k = 0; k < c->source_count; k++) {
        rsv_free(c->context, c->list[k].chain);
        rsv_free(c->context, c->list[k].event);
        rsv_free(c->context, c->list[k].beam);
    }
    rsv_free(c->context, c->list);
    rsv_free(c->context, c->source);
    rsv_free(c->context, c);
}
