#include "connect_internal.h"

#include "../core/morton.h"
#include "../core/parallel.h"
#include "../core/sampling.h"

#include <stdlib.h>
#include <string.h>

/// Rays towards smooth surfaces, for all sources together, by solid angle; each triangle gets one more if there are
/// fewer.
#define RAYS 8192
#define LEAST_RAYS 1024 ///< of a source
#define FAINT 3e-4f     ///< chains that leave less of the light are left out
#define NEARBY 1.25     ///< extents of a chain's first triangle within which it is tried
#define NEARBY_RAYS 2.0 ///< likewise, spacings of rays
#define WIDE 0.5    ///< radians, or of the scene's radius: chains that are wider are always tried
#define LEVEL 1e-4f ///< difference of normals below which facets are one
#define BRANCHES 64 ///< of a ray that wait to be followed
#define MOST_CHAINS ((size_t)1 << 18) ///< of a source

/// A smooth triangle, and its place along Morton's curve: neighbours share rays out evenly.
typedef struct smooth_triangle {
    uint64_t key;
    uint32_t triangle;
} smooth_triangle;

typedef struct target_list {
    smooth_triangle *target; ///< [count], by key
    size_t count;
} target_list;

/// A ray of the search at a surface.
typedef struct branch {
    rsv_specular_path path;
    float passed; ///< fraction of the light that has only passed blended surfaces
    uint32_t count;
    rsv_chain_event event[RSV_CHAIN_EVENTS];
} branch;

typedef struct search {
    const rsv_connections *c;
    rsv_chain_list *list;
    uint64_t *known; ///< [known_size] hashes of chains; 0 = free
    size_t known_size;
    rsv_chain chain; ///< of the ray that is followed
    double spacing;  ///< of rays where these are fewer than triangles, by u and v; else 0
    branch wait[BRANCHES];
    int waiting;
    rsv_status status;
} search;

bool rsv_chain_set_out(const rsv_connections *c, const rsv_connect_source *source,
    const rsv_double_ray *ray, rsv_channel channel, rsv_specular_path *path)
{
    const rsv_ray way = { d3_to_float(ray->origin), d3_to_float(ray->direction), INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(c->scene.tracer, &way, &hit)) return false;
    *path = rsv_specular_begin(&c->scene, &source->medium, way.direction, hit);
    path->channel = channel;
    return true;
}

// ---- known chains --------------------------------------------------------------------------------

static uint64_t hash_of(const search *s, const rsv_chain_event *event, uint32_t count)
{
    uint64_t hash = 0x9e3779b97f4a7c15u + s->chain.channel;
    for (uint32_t k = 0; k < count; k++) {
        hash ^=
            ((uint64_t)event[k].triangle << 3 | (uint64_t)event[k].kind << 1 | event[k].back) + 1;
        hash *= 0xff51afd7ed558ccdu;
        hash ^= hash >> 32;
    }
    return hash ? hash : 1;
}

static void insert(uint64_t *known, size_t size, uint64_t hash)
{
    size_t at = hash & (size - 1);
    while (known[at])
        at = (at + 1) & (size - 1);
    known[at] = hash;
}

static bool is_known(const search *s, uint64_t hash)
{
    for (size_t at = hash & (s->known_size - 1); s->known[at]; at = (at + 1) & (s->known_size - 1))
        if (s->known[at] == hash) return true;
    return false;
}

static rsv_status make_room(search *s)
{
    if (2 * s->list->count < s->known_size) return RSV_OK;
    size_t size = 2 * s->known_size;
    uint64_t *known = rsv_alloc(s->c->context, size, sizeof *known);
    if (!known) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < s->known_size; k++)
        if (s->known[k]) insert(known, size, s->known[k]);
    rsv_free(s->c->context, s->known);
    s->known = known;
    s->known_size = size;
    return RSV_OK;
}

static rsv_chain_beam beam_of(const search *s, const rsv_double_ray end[3], uint32_t triangle)
{
    double extent =
        fmax(NEARBY_RAYS * s->spacing, NEARBY * rsv_chain_extent(s->c, &s->chain.seed, triangle));
    double wide = s->chain.seed.distant ? WIDE * s->c->radius : WIDE;
    return (rsv_chain_beam){ d3_to_float(end[0].origin), d3_to_float(end[0].direction),
        d3_to_float(end[1].origin), d3_to_float(end[2].origin), d3_to_float(end[1].direction),
        d3_to_float(end[2].direction), extent < wide ? (float)extent : INFINITY };
}

/// Adds the chain of these events, if it is a new one.
static rsv_status add_chain(search *s, const rsv_chain_event *event, uint32_t count)
{
    rsv_status status;
    rsv_chain_list *list = s->list;
    rsv_chain chain = s->chain;
    rsv_double_ray end[3];
    uint64_t hash = hash_of(s, event, count);
    chain.count = count;
    chain.first = (uint32_t)list->event_count;
    if (list->count == MOST_CHAINS || is_known(s, hash)) return RSV_OK;
    if (!rsv_chain_differentiate(s->c, &chain, event, (double[2]){ 0, 0 }, end)) return RSV_OK;
    RSV_TRY(make_room(s));
    RSV_TRY(rsv_grow(s->c->context, (void **)&list->chain, &list->capacity, list->count + 1,
        sizeof *list->chain));
    RSV_TRY(rsv_grow(s->c->context, (void **)&list->event, &list->event_capacity,
        list->event_count + count, sizeof *list->event));
    RSV_TRY(rsv_grow(s->c->context, (void **)&list->beam, &list->beam_capacity, list->count + 1,
        sizeof *list->beam));
    insert(s->known, s->known_size, hash);
    list->beam[list->count] = beam_of(s, end, event[0].triangle);
    list->chain[list->count++] = chain;
    memcpy(list->event + list->event_count, event, count * sizeof *event);
    list->event_count += count;
cleanup:
    return status;
}

// ---- rays ---------------------------------------------------------------------------------------

/// Adds the ray's event at its surface as a chain, to be continued from there later.
static void branch_off(search *s, const branch *from, bool transmit, const rsv_bsdf_branches *lobe)
{
    rsv_rgb weight = transmit ? lobe->transmit : lobe->reflect;
    const rsv_specular_path *path = &from->path;
    rsv_bsdf storage;
    float opacity = rsv_specular_bsdf(&s->c->scene, path, &storage)->opacity;
    branch next = *from;
    next.passed *= transmit ? 1 - opacity : 0;
    rsv_chain_event *event = &next.event[next.count++];
    *event = (rsv_chain_event){ path->triangle,
        rsv_chain_kind_of(&s->c->scene, path->triangle, transmit), path->back };
    if (rgb_max(rgb_mul(path->weight, weight)) < FAINT || s->status != RSV_OK) return;
    if (rgb_max(rgb_mul(path->weight, weight)) - next.passed >= FAINT)
        s->status = add_chain(s, next.event, next.count);
    if (next.count == RSV_CHAIN_EVENTS || s->waiting == BRANCHES) return;
    rsv_vec3 direction = transmit ? lobe->transmit_direction : lobe->reflect_direction;
    if (rsv_specular_step(&s->c->scene, &next.path, transmit, direction, weight) !=
        RSV_SPECULAR_MOVED)
        return;
    s->wait[s->waiting++] = next;
}

/// @param target triangle that the ray is meant for: one that meets another part of the same thing is not followed
static void follow_ray(search *s, const rsv_connect_source *source, uint32_t target)
{
    const rsv_transport_scene *scene = &s->c->scene;
    branch *first = &s->wait[0];
    *first = (branch){ .passed = 1 };
    if (!rsv_chain_set_out(s->c, source, &s->chain.seed.ray, s->chain.channel, &first->path))
        return;
    if (first->path.triangle != target &&
        rsv_specular_material(scene, &first->path) == scene->view->triangle_material[target])
        return;
    s->waiting = 1;
    while (s->waiting) {
        const branch at = s->wait[--s->waiting];
        rsv_bsdf_branches lobe = rsv_specular_branches(scene, &at.path);
        branch_off(s, &at, false, &lobe);
        branch_off(s, &at, true, &lobe);
    }
}

static void shoot_at(
    search *s, const rsv_connect_source *source, rsv_vec3 target, uint32_t triangle)
{
    rsv_chain_seed *seed = &s->chain.seed;
    seed->distant = rsv_punctual_is_distant(source->light);
    seed->ray.origin = d3_from(source->place);
    rsv_double3 way = d3_between(source->place, target);
    if (seed->distant) {
        seed->ray.direction = d3_normalize(d3_from(source->light->direction));
        double along = d3_dot(way, seed->ray.direction);
        seed->ray.origin = d3_mad(d3_from(target), -along, seed->ray.direction);
    } else {
        seed->ray.direction = d3_normalize(way);
    }
    if (!(d3_length(seed->ray.direction) > 0)) return;
    bool apart = s->c->disperses;
    for (int k = apart ? RSV_CHANNEL_RED : RSV_CHANNEL_ALL;
         k <= (apart ? RSV_CHANNEL_BLUE : RSV_CHANNEL_ALL); k++) {
        s->chain.channel = (rsv_channel)k;
        follow_ray(s, source, triangle);
    }
}

static bool is_smooth(const rsv_bsdf *b)
{
    return !b->lambert && !b->unlit &&
           (b->alpha == 0 || b->straight || (b->clearcoat > 0 && b->clearcoat_alpha == 0));
}

/// Solid angle of a triangle seen from the source, roughly; of distant ones, its projected area.
static double seen_from(const search *s, const rsv_connect_source *source, uint32_t triangle)
{
    const rsv_scene_view *view = s->c->scene.view;
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]], b = view->position[corner[1]],
             c = view->position[corner[2]];
    rsv_double3 n = d3_cross(d3_between(a, b), d3_between(a, c));
    if (rsv_punctual_is_distant(source->light))
        return 0.5 * fabs(d3_dot(n, d3_from(source->light->direction)));
    rsv_double3 way = d3_between(source->place, v3_barycentric(a, b, c, 1.0f / 3, 1.0f / 3));
    double distance = d3_length(way);
    if (!(distance > 0)) return 0;
    return fmin(2 * M_PI, 0.5 * fabs(d3_dot(n, way)) / (distance * distance * distance));
}

/// @param index of a ray to the triangle, the first of which goes to the middle
static void shoot(search *s, const rsv_connect_source *source, uint32_t triangle, uint32_t index)
{
    const rsv_scene_view *view = s->c->scene.view;
    const uint32_t *corner = view->triangle[triangle];
    float u = 1.0f / 3, v = 1.0f / 3;
    if (index) {
        rsv_sobol_2d(index, rsv_hash(triangle), &u, &v);
        float root = sqrtf(u);
        u = 1 - root, v *= root;
    }
    shoot_at(s, source,
        v3_barycentric(
            view->position[corner[0]], view->position[corner[1]], view->position[corner[2]], u, v),
        triangle);
}

/// Divides rays among triangles by solid angle. If there are fewer triangles than rays, each gets one more.
static void search_from(
    search *s, const rsv_connect_source *source, const target_list *targets, double rays)
{
    double all = 0, due = 0;
    for (size_t k = 0; k < targets->count; k++)
        all += seen_from(s, source, targets->target[k].triangle);
    bool each = (double)targets->count <= rays;
    if (!each) s->spacing = sqrt(all / rays);
    for (size_t k = 0; k < targets->count && s->status == RSV_OK; k++) {
        if (rsv_cancelled(s->c->context)) return;
        uint32_t triangle = targets->target[k].triangle, count = each;
        due += all > 0 ? rays * seen_from(s, source, triangle) / all : 0;
        for (; due >= 1; due--)
            count++;
        for (uint32_t r = 0; r < count && s->status == RSV_OK; r++)
            shoot(s, source, triangle, r);
    }
}

static rsv_status search_source(
    const rsv_connections *c, size_t index, const target_list *targets, double rays)
{
    search *s = rsv_alloc(c->context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    *s = (search){ .c = c, .list = &c->list[index], .known_size = 1024 };
    s->chain.source = (uint32_t)index;
    s->known = rsv_alloc(c->context, s->known_size, sizeof *s->known);
    s->status = s->known ? RSV_OK : RSV_ERROR_MEMORY;
    if (s->known) search_from(s, &c->source[index], targets, rays);
    rsv_status status = s->status;
    rsv_free(c->context, s->known);
    rsv_free(c->context, s);
    return status;
}

// ---- targets ------------------------------------------------------------------------------------

static int compare_targets(const void *a, const void *b)
{
    const smooth_triangle *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static uint64_t key_of(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 at = v3_barycentric(view->position[corner[0]], view->position[corner[1]],
        view->position[corner[2]], 1.0f / 3, 1.0f / 3);
    rsv_vec3 from = v3_sub(at, view->bounds_min), size = v3_sub(view->bounds_max, view->bounds_min);
    float scale = 1 / f_max(v3_max_abs(size), 1e-30f);
    return rsv_morton_key(from.x * scale, from.y * scale, from.z * scale, RSV_MORTON_BITS);
}

static rsv_status list_targets(const rsv_connections *c, target_list *list)
{
    const rsv_scene_view *view = c->scene.view;
    size_t count = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        count += is_smooth(&c->scene.bsdf[view->triangle_material[t]]);
    *list = (target_list){ rsv_alloc(c->context, count, sizeof *list->target), 0 };
    if (!list->target) return RSV_ERROR_MEMORY;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        if (is_smooth(&c->scene.bsdf[view->triangle_material[t]]))
            list->target[list->count++] = (smooth_triangle){ key_of(view, t), t };
    qsort(list->target, count, sizeof *list->target, compare_targets);
    return RSV_OK;
}

/// The normal of a triangle that does not interpolate one; else zero.
static rsv_vec3 flat_normal(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 n = view->normal[corner[0]];
    bool flat = v3_max_abs(v3_sub(n, view->normal[corner[1]])) < LEVEL &&
                v3_max_abs(v3_sub(n, view->normal[corner[2]])) < LEVEL;
    return flat ? n : v3(0, 0, 0);
}

/// Rays can only be followed from facet to facet if normals describe the curvature. Without normals, most of many
/// facets are missed.
static void warn_of_facets(const rsv_connections *c, const target_list *targets, double rays)
{
    const rsv_scene_view *view = c->scene.view;
    rsv_vec3 before = v3(0, 0, 0);
    size_t facets = 0;
    for (size_t k = 0; k < targets->count; k++) {
        rsv_vec3 n = flat_normal(view, targets->target[k].triangle);
        bool turns = v3_max_abs(n) > 0 && v3_max_abs(v3_sub(n, before)) > LEVEL;
        facets += turns;
        if (v3_max_abs(n) > 0) before = n;
        if ((double)facets <= rays || !turns) continue;
        uint32_t material = view->triangle_material[targets->target[k].triangle];
        rsv_log(c->context, RSV_LOG_WARNING,
            "material '%s': it has more than %.0f flat facets, so probes miss most of the light "
            "that lamps send through them; give the mesh smooth normals",
            view->material[material].name, rays);
        return;
    }
}

typedef struct search_job {
    rsv_connections *connections;
    const target_list *targets;
    double rays; ///< per source
    _Atomic rsv_status result;
} search_job;

static void search_sources(void *user, rsv_span span)
{
    search_job *job = user;
    for (size_t k = span.begin; k < span.end; k++)
        rsv_keep_failure(&job->result, search_source(job->connections, k, job->targets, job->rays));
}

rsv_status rsv_chains_find(rsv_connections *c)
{
    rsv_status status;
    target_list targets = { 0 };
    double rays = fmax(LEAST_RAYS, RAYS / (double)c->source_count);
    RSV_TRY(list_targets(c, &targets));
    if ((double)targets.count > rays) warn_of_facets(c, &targets, rays);
    search_job job = { c, &targets, rays, RSV_OK };
    rsv_parallel_for(c->context, c->source_count, 1, search_sources, &job);
    status = job.result;
cleanup:
    rsv_free(c->context, targets.target);
    return status;
}
