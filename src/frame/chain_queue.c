#include "chain_queue.h"

#include "../render/camera_chain.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

rsv_status rsv_chain_queue_create(const rsv_light_table *table, rsv_chain_queue *q)
{
    *q = (rsv_chain_queue){ .table = table, .scene = &table->solution->scene };
    memset(q->packet.mask, 0xff, sizeof q->packet.mask);
    rsv_chain_queue_refresh(q);
    for (int kind = 0; kind < 2; kind++) {
        q->traveller[kind] =
            rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->traveller[kind]);
        if (!q->traveller[kind]) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

void rsv_chain_queue_refresh(rsv_chain_queue *q)
{
    q->lights = q->table->solution->lights;
    q->sky = q->lights->environment ? q->lights->environment->whole : (rsv_sky){ 0 };
}

void rsv_chain_queue_destroy(rsv_chain_queue *q)
{
    if (!q->table) return;
    rsv_free(q->table->context, q->traveller[0]);
    rsv_free(q->table->context, q->traveller[1]);
}

static void add_light(rsv_chain_queue *q, uint32_t pixel, rsv_rgb light)
{
    float *sum = q->radiance[pixel];
    sum[0] += light.r, sum[1] += light.g, sum[2] += light.b;
}

void rsv_chain_queue_add_sky(rsv_chain_queue *q, rsv_vec3 direction, rsv_rgb weight, uint32_t pixel)
{
    if (q->sky.pixel && rsv_shows_emission(q->table))
        add_light(q, pixel, rgb_mul(weight, rsv_sky_radiance(&q->sky, direction)));
}

static rsv_rgb without(rsv_rgb a, rsv_rgb b)
{
    return rgb(f_max(a.r - b.r, 0), f_max(a.g - b.g, 0), f_max(a.b - b.b, 0));
}

rsv_rgb rsv_shade_stored(const rsv_light_table *table, const rsv_mover *mover, uint32_t triangle,
    float u, float v, bool back, uint32_t stream, rsv_rgb shown)
{
    const rsv_solution *s = table->solution;
    if (s->elements->face_of[back][triangle] == RSV_NONE) return shown;
    rsv_surface_point point = rsv_surface_point_at(s->scene.view, triangle, u, v, back);
    rsv_rgb albedo = s->bsdf[s->scene.view->triangle_material[triangle]].exitance_albedo;
    rsv_rgb kept = rsv_mover_shadow(mover, &point, stream);
    return without(shown, rgb_scale(rgb_mul(albedo, kept), 1 / RSV_PI));
}

/// A diffuse surface that is not in the table. @param weight radiance at the camera per B / pi
static void add_diffuse(void *user, const rsv_chain *chain, rsv_rgb weight)
{
    rsv_chain_queue *q = user;
    const rsv_solution *s = q->table->solution;
    uint32_t face = s->elements->face_of[chain->back][chain->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(q->scene, chain, &storage);
    rsv_rgb shown = rsv_shown_irradiance(q->table, face, chain->u, chain->v);
    if (q->mover) {
        rsv_surface_point point =
            rsv_surface_point_at(q->scene->view, chain->triangle, chain->u, chain->v, chain->back);
        shown = without(shown, rsv_mover_shadow(q->mover, &point, q->path));
    }
    add_light(
        q, q->pixel, rgb_mul(rgb_scale(rgb_mul(weight, bsdf->exitance_albedo), 1 / RSV_PI), shown));
}

/// Leaves a chain to rsv_camera_chain.
static void follow_at_once(rsv_chain_queue *q, const rsv_chain *chain, uint32_t path)
{
    rsv_rgb found = rsv_camera_chain(
        q->scene, q->lights, *chain, path, NULL, q->max_events, false, add_diffuse, q);
    if (rsv_shows_emission(q->table)) add_light(q, q->pixel, found);
}

static void add_emission(rsv_chain_queue *q, const rsv_chain *chain, rsv_rgb throughput)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(q->scene, chain, &storage);
    bool shows = (bsdf->emissive || bsdf->unlit) && (!chain->back || bsdf->double_sided);
    if (shows && rsv_shows_emission(q->table))
        add_light(q, q->pixel, rgb_mul(throughput, rgb_scale(bsdf->emission, bsdf->opacity)));
}

/// Sets one ideal branch out.
static void queue_branch(rsv_chain_queue *q, const rsv_chain *chain, const rsv_surface_point *point,
    uint32_t path, bool transmit, const rsv_bsdf_branches *branches)
{
    rsv_rgb weight = transmit ? branches->transmit : branches->reflect;
    rsv_vec3 direction = transmit ? branches->transmit_direction : branches->reflect_direction;
    rsv_ray ray;
    if (chain->events >= q->max_events || !rsv_branch_survives(chain, path, transmit, &weight) ||
        !rsv_chain_depart(point, transmit, direction, &ray))
        return;
    rsv_chain_traveller *t = &q->traveller[transmit][q->waiting[transmit]++];
    t->chain = *chain;
    t->origin = ray.origin;
    t->path = rsv_branch_path(path, transmit);
    t->pixel = q->pixel;
    rsv_chain_set_out(q->scene, &t->chain, transmit, direction, weight);
}

static bool has_room(const rsv_chain_queue *q)
{
    return q->waiting[0] < RSV_QUEUE_CAPACITY && q->waiting[1] < RSV_QUEUE_CAPACITY;
}

void rsv_chain_queue_add(rsv_chain_queue *q, const rsv_chain *chain, uint32_t path, uint32_t pixel)
{
    q->pixel = pixel;
    q->path = path;
    rsv_rgb throughput = rsv_chain_throughput(q->scene, chain, &chain->medium);
    rsv_shown_side side = *rsv_shown_side_of(q->table, chain->triangle, chain->back);
    if (side.kind == RSV_SHOWN_STORED) {
        rsv_float4 light =
            rsv_light_at(q->table->cell, rsv_place_in_grid(side, chain->u, chain->v));
        rsv_rgb shown = rgb(light[0], light[1], light[2]);
        if (q->mover)
            shown = rsv_shade_stored(
                q->table, q->mover, chain->triangle, chain->u, chain->v, chain->back, path, shown);
        add_light(q, pixel, rgb_mul(throughput, shown));
        return;
    }
    rsv_surface_point point = rsv_surface_point_seen(
        q->scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
    rsv_bsdf_branches branches = rsv_chain_branches_at(q->scene, chain, &point);
    if (branches.rough || !has_room(q)) {
        follow_at_once(q, chain, path);
        return;
    }
    add_emission(q, chain, throughput);
    if (!rgb_is_black(branches.diffuse))
        add_diffuse(q, chain, rgb_mul(throughput, branches.diffuse));
    queue_branch(q, chain, &point, path, false, &branches);
    queue_branch(q, chain, &point, path, true, &branches);
}

static void load_lane(rsv_ray_packet *p, uint32_t k, const rsv_chain_traveller *t)
{
    p->origin_x[k] = t->origin.x;
    p->origin_y[k] = t->origin.y;
    p->origin_z[k] = t->origin.z;
    p->direction_x[k] = t->chain.direction.x;
    p->direction_y[k] = t->chain.direction.y;
    p->direction_z[k] = t->chain.direction.z;
    p->t_max[k] = INFINITY;
}

/// Ends a chain at the mover.
static void meet_mover(rsv_chain_queue *q, uint32_t k, const rsv_chain_traveller *t)
{
    const rsv_chain *chain = &t->chain;
    rsv_rgb dimmed = rsv_medium_transmittance(&chain->medium, q->scene->bsdf, q->body.t_max[k]);
    rsv_rgb throughput = rsv_chain_throughput(q->scene, chain, &chain->medium);
    rsv_rgb shown = rsv_mover_shown(q->mover, &q->body, k);
    add_light(q, t->pixel, rgb_mul(rgb_mul(throughput, dimmed), shown));
}

static void arrive(rsv_chain_queue *q, uint32_t k, rsv_chain_traveller *t)
{
    const rsv_ray_packet *p = &q->packet;
    rsv_chain *chain = &t->chain;
    if (p->triangle[k] == RSV_NONE) {
        rsv_rgb throughput = rsv_chain_throughput(q->scene, chain, &chain->medium);
        rsv_chain_queue_add_sky(q, chain->direction, throughput, t->pixel);
        return;
    }
    rsv_hit hit = { p->triangle[k], p->t_max[k], p->u[k], p->v[k] };
    rsv_chain_arrive(q->scene, chain, &hit);
    rsv_chain_queue_add(q, chain, t->path, t->pixel);
}

/// Traces the travellers that came last, and what becomes of them.
static void run_packet(rsv_chain_queue *q)
{
    int kind = q->waiting[1] >= q->waiting[0];
    uint32_t count = q->waiting[kind] < LANES ? q->waiting[kind] : LANES;
    rsv_chain_traveller traveller[LANES];
    q->waiting[kind] -= count;
    memcpy(traveller, q->traveller[kind] + q->waiting[kind], count * sizeof *traveller);
    for (uint32_t k = 0; k < LANES; k++) {
        if (k < count)
            load_lane(&q->packet, k, &traveller[k]);
        else
            q->packet.t_max[k] = -1;
    }
    rsv_tracer_closest_packet(q->scene->tracer, &q->packet, true);
    q->rays += count;
    uint32_t met = q->mover ? rsv_mover_meet(q->mover, &q->packet, &q->body) : 0;
    for (uint32_t k = 0; k < count; k++) {
        if (met >> k & 1)
            meet_mover(q, k, &traveller[k]);
        else
            arrive(q, k, &traveller[k]);
    }
}

void rsv_chain_queue_run(rsv_chain_queue *q)
{
    while (q->waiting[0] + q->waiting[1] > 0)
        run_packet(q);
}
