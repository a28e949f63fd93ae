#include "chain_queue.h"

#include "../render/branch.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

rsv_status rsv_chain_queue_create(
    const rsv_light_table *table, const rsv_packet_kernels *kernels, rsv_chain_queue *q)
{
    *q = (rsv_chain_queue){ .kernels = kernels,
        .light = { .table = table, .scene = &table->solution->scene } };
    rsv_chain_light_refresh(&q->light);
    for (int stage = 0; stage < RSV_STAGES; stage++)
        memset(q->packet[stage].rays.mask, 0xff, sizeof q->packet[stage].rays.mask);
    q->waiting = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->waiting);
    q->moving = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->moving);
    q->order = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->order);
    return q->waiting && q->moving && q->order ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_chain_queue_destroy(rsv_chain_queue *q)
{
    if (!q->light.table) return;
    rsv_context *context = q->light.table->context;
    rsv_free(context, q->waiting);
    rsv_free(context, q->moving);
    rsv_free(context, q->order);
}

// ---- at surfaces --------------------------------------------------------------------------------

#define KINDS 32

/// Branches from the same part of a picture run alike if they are of one kind: reflected or transmitted, from the same
/// side of a surface, into the same octant.
static uint32_t kind_of(const rsv_chain *chain, bool transmit, rsv_vec3 direction)
{
    uint32_t octant = (uint32_t)(direction.x < 0) | (uint32_t)(direction.y < 0) << 1 |
                      (uint32_t)(direction.z < 0) << 2;
    return octant | (uint32_t)transmit << 3 | (uint32_t)chain->back << 4;
}

/// Sets one ideal branch out.
static void queue_branch(rsv_chain_queue *q, const rsv_chain *chain, const rsv_surface_point *point,
    bool transmit, const rsv_bsdf_branches *branches)
{
    rsv_rgb weight = transmit ? branches->transmit : branches->reflect;
    rsv_vec3 direction = transmit ? branches->transmit_direction : branches->reflect_direction;
    rsv_ray ray;
    if (chain->events >= q->light.max_events ||
        !rsv_branch_survives(chain, q->light.path, transmit, &weight) ||
        !rsv_chain_depart(point, transmit, direction, &ray))
        return;
    rsv_chain_traveller *t = &q->waiting[q->waiting_count++];
    t->chain = *chain;
    t->origin = ray.origin;
    t->path = rsv_branch_path(q->light.path, transmit);
    t->pixel = q->light.pixel;
    t->kind = kind_of(chain, transmit, direction);
    rsv_chain_set_out(q->light.scene, &t->chain, transmit, direction, weight);
}

static bool has_room(const rsv_chain_queue *q)
{
    return q->waiting_count + 2 <= RSV_QUEUE_CAPACITY;
}

/// What a surface shows that is not in the table, and its branches.
static void scatter(rsv_chain_queue *q, const rsv_chain *chain)
{
    rsv_bsdf storage;
    const rsv_transport_scene *scene = q->light.scene;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(scene, chain, &storage);
    rsv_surface_point point = rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
    rsv_bsdf_branches branches = rsv_chain_branches_of(bsdf, chain, &point);
    if (branches.rough || !has_room(q)) {
        rsv_add_whole_chain(&q->light, chain);
        return;
    }
    rsv_rgb throughput = rsv_chain_throughput(scene, chain, &chain->medium);
    rsv_add_emission(&q->light, chain, bsdf, throughput);
    if (!rgb_is_black(branches.diffuse))
        rsv_add_diffuse_end(&q->light, chain, rgb_mul(throughput, branches.diffuse));
    queue_branch(q, chain, &point, false, &branches);
    queue_branch(q, chain, &point, true, &branches);
}

void rsv_chain_queue_add(rsv_chain_queue *q, const rsv_chain *chain, uint32_t path, uint32_t pixel)
{
    q->light.pixel = pixel;
    q->light.path = path;
    rsv_shown_side side = *rsv_shown_side_of(q->light.table, chain->triangle, chain->back);
    if (side.kind == RSV_SHOWN_STORED)
        rsv_add_stored(&q->light, chain,
            rsv_descend(q->light.table->cell, rsv_place_in_grid(side, chain->u, chain->v)));
    else
        scatter(q, chain);
}

static void arrive(rsv_chain_queue *q, const rsv_chain_packet *p, uint32_t lane, rsv_chain *chain)
{
    const rsv_ray_packet *r = &p->rays;
    if (r->triangle[lane] == RSV_NONE) {
        rsv_rgb throughput = rsv_chain_throughput(q->light.scene, chain, &chain->medium);
        rsv_add_sky(&q->light, chain->direction, throughput);
        return;
    }
    rsv_hit hit = { r->triangle[lane], r->t_max[lane], r->u[lane], r->v[lane] };
    rsv_chain_arrive_at(q->light.scene, chain, &hit, rsv_packet_meets_back(r, lane));
    if (p->left >> lane & 1)
        scatter(q, chain);
    else
        rsv_add_stored(&q->light, chain, rsv_packet_place(&p->places, lane));
}

// ---- from surface to surface ----------------------------------------------------------------------

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

/// Whether rays run in about the same direction.
static bool are_coherent(const rsv_ray_packet *p, uint32_t count)
{
    float x = 0, y = 0, z = 0, least = 0.95f * (float)count;
    for (uint32_t k = 0; k < count; k++)
        x += p->direction_x[k], y += p->direction_y[k], z += p->direction_z[k];
    return x * x + y * y + z * z >= least * least;
}

static void trace(rsv_chain_queue *q, rsv_chain_packet *p)
{
    for (uint32_t k = 0; k < LANES; k++) {
        if (k < p->count)
            load_lane(&p->rays, k, &q->moving[p->member[k]]);
        else
            p->rays.t_max[k] = -1;
    }
    rsv_tracer_closest_packet(q->light.scene->tracer, &p->rays, are_coherent(&p->rays, p->count));
    q->kernels->approach(q->light.table, &p->rays);
    q->rays += p->count;
}

static void prefetch_corners(const rsv_scene_view *view, uint32_t triangle)
{
    for (int k = 0; k < 3; k++) {
        __builtin_prefetch(&view->position[view->triangle[triangle][k]]);
        __builtin_prefetch(&view->normal[view->triangle[triangle][k]]);
    }
}

static void locate(rsv_chain_queue *q, rsv_chain_packet *p)
{
    p->left = q->kernels->locate(q->light.table, &p->rays, &p->places);
    for (uint32_t k = 0; k < p->count; k++)
        if (p->left >> k & 1 && p->rays.triangle[k] != RSV_NONE)
            prefetch_corners(q->light.scene->view, p->rays.triangle[k]);
}

static void descend(rsv_chain_queue *q, rsv_chain_packet *p)
{
    q->kernels->descend(q->light.table, &p->places);
}

static void end_steps(rsv_chain_queue *q, const rsv_chain_packet *p)
{
    const rsv_mover *mover = q->light.mover;
    uint32_t met = mover ? rsv_mover_meet(mover, &p->rays, &q->body) : 0;
    for (uint32_t k = 0; k < p->count; k++) {
        rsv_chain_traveller *t = &q->moving[p->member[k]];
        q->light.pixel = t->pixel;
        q->light.path = t->path;
        if (met >> k & 1)
            rsv_add_mover(&q->light, &t->chain, &q->body, k);
        else
            arrive(q, p, k, &t->chain);
    }
}

/// Sets all that wait moving, ordered by kind and otherwise as they came.
static void set_moving(rsv_chain_queue *q)
{
    uint32_t first[KINDS + 1] = { 0 };
    rsv_chain_traveller *moving = q->waiting;
    q->waiting = q->moving;
    q->moving = moving;
    q->moving_count = q->waiting_count;
    q->waiting_count = 0;
    for (uint32_t k = 0; k < q->moving_count; k++)
        first[moving[k].kind + 1]++;
    for (int kind = 0; kind < KINDS; kind++)
        first[kind + 1] += first[kind];
    for (uint32_t k = 0; k < q->moving_count; k++)
        q->order[first[moving[k].kind]++] = k;
}

static rsv_chain_packet *packet_at(rsv_chain_queue *q, uint32_t index)
{
    rsv_chain_packet *p = &q->packet[index % RSV_STAGES];
    uint32_t first = index * LANES, left = q->moving_count - first;
    p->member = q->order + first;
    p->count = left < LANES ? left : LANES;
    return p;
}

/// All that wait take one step, every packet one stage behind the one after it.
static void step(rsv_chain_queue *q)
{
    set_moving(q);
    uint32_t count = (q->moving_count + LANES - 1) / LANES;
    for (uint32_t n = 0; n < count + RSV_STAGES - 1; n++) {
        if (n < count) trace(q, packet_at(q, n));
        if (n >= 1 && n - 1 < count) locate(q, packet_at(q, n - 1));
        if (n >= 2 && n - 2 < count) descend(q, packet_at(q, n - 2));
        if (n >= 3) end_steps(q, packet_at(q, n - 3));
    }
}

void rsv_chain_queue_run(rsv_chain_queue *q)
{
    while (q->waiting_count > 0)
        step(q);
}
