#include "specular_queue.h"

#include "../trace/packet.h"

#include <string.h>

#define LANES RSV_LANES

rsv_status rsv_specular_queue_create(const rsv_light_table *table,
    const rsv_packet_kernels *kernels, const rsv_specular_media *media,
    const rsv_clearances *clearances, rsv_specular_queue *q)
{
    *q = (rsv_specular_queue){ .kernels = kernels,
        .media = media,
        .clearances = clearances,
        .light = { .table = table, .scene = &table->solution->scene } };
    rsv_specular_light_refresh(&q->light);
    for (int stage = 0; stage < RSV_STAGES; stage++)
        memset(q->packet[stage].rays.mask, 0xff, sizeof q->packet[stage].rays.mask);
    q->waiting = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->waiting);
    q->moving = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->moving);
    q->kind = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->kind);
    q->order = rsv_alloc(table->context, RSV_QUEUE_CAPACITY, sizeof *q->order);
    if (!q->waiting || !q->moving || !q->kind || !q->order) return RSV_ERROR_MEMORY;
    if (!table->glossy) return RSV_OK;
    q->lobes = rsv_alloc(table->context, 1, sizeof *q->lobes);
    q->irradiance = rsv_alloc(table->context, RSV_BLOCK * RSV_TILE, sizeof *q->irradiance);
    return q->lobes && q->irradiance ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_specular_queue_destroy(rsv_specular_queue *q)
{
    if (!q->light.table) return;
    rsv_context *context = q->light.table->context;
    rsv_free(context, q->waiting);
    rsv_free(context, q->moving);
    rsv_free(context, q->kind);
    rsv_free(context, q->order);
    rsv_free(context, q->lobes);
    rsv_free(context, q->irradiance);
}

static void load_lane(rsv_specular_packet *p, uint32_t k, const rsv_specular_traveller *t)
{
    rsv_ray ray = { t->origin, t->direction, INFINITY };
    rsv_packet_set_ray(&p->rays, k, ray);
    p->rays.t_min[k] = t->t_min;
    rsv_specular_lanes *c = &p->paths;
    rsv_set_lane_color(c->weight, k, t->weight);
    c->start_ior[k] = t->start_ior;
    c->width[k] = t->width;
    c->trail[k] = t->trail;
    c->pixel[k] = t->pixel;
    c->events[k] = t->events;
    c->medium[k] = t->medium;
    c->settled[k] = t->settled;
}

/// Whether rays run in about the same direction.
static bool are_coherent(const rsv_ray_packet *p, uint32_t count)
{
    float x = 0, y = 0, z = 0, least = 0.95f * (float)count;
    for (uint32_t k = 0; k < count; k++)
        x += p->direction_x[k], y += p->direction_y[k], z += p->direction_z[k];
    return x * x + y * y + z * z >= least * least;
}

static void depart(rsv_specular_queue *q, rsv_specular_packet *p)
{
    for (uint32_t k = 0; k < LANES; k++) {
        if (k < p->count)
            load_lane(p, k, &q->moving[p->member[k]]);
        else
            p->rays.t_max[k] = -1;
    }
    rsv_tracer_closest_packet(q->light.scene->tracer, &p->rays, are_coherent(&p->rays, p->count));
    q->kernels->approach(q->light.table, &p->rays);
    q->rays += p->count;
}

static void locate(rsv_specular_queue *q, rsv_specular_packet *p)
{
    p->left = q->kernels->locate(q->light.table, &p->rays, &p->places);
    rsv_prefetch_triangles(q->light.scene->view, &p->rays, p->left);
}

static void descend(rsv_specular_queue *q, rsv_specular_packet *p)
{
    q->kernels->descend(q->light.table, &p->places);
    rsv_prefetch_corners(q->light.scene->view, &p->rays, p->left);
}

/// Ends specular paths that the mover stands in the way of. @return their lanes
static uint32_t end_at_mover(rsv_specular_queue *q, const rsv_specular_packet *p, uint32_t lanes)
{
    if (!q->light.mover) return 0;
    uint32_t met = rsv_mover_meet(q->light.mover, &p->rays, &q->body) & lanes;
    for (uint32_t left = met; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        rsv_specular_path path = rsv_specular_of_lane(q, &p->rays, &p->paths, k);
        q->light.pixel = p->paths.pixel[k];
        rsv_add_mover(&q->light, &path, &q->body, k);
    }
    return met;
}

static void arrive(rsv_specular_queue *q, rsv_specular_packet *p)
{
    uint32_t lanes = (1u << p->count) - 1;
    const rsv_arrival arrival = { &p->rays, &p->places, p->left, &p->paths };
    rsv_specular_queue_arrive(q, &arrival, lanes & ~end_at_mover(q, p, lanes));
}

/// Starts all waiting paths, ordered by kind and otherwise as they came.
static void set_moving(rsv_specular_queue *q)
{
    uint32_t first[RSV_BRANCH_KINDS + 1] = { 0 };
    rsv_specular_traveller *moving = q->waiting;
    q->waiting = q->moving;
    q->moving = moving;
    q->moving_count = q->waiting_count;
    q->waiting_count = 0;
    for (uint32_t k = 0; k < q->moving_count; k++)
        first[q->kind[k] + 1]++;
    for (int kind = 0; kind < RSV_BRANCH_KINDS; kind++)
        first[kind + 1] += first[kind];
    for (uint32_t k = 0; k < q->moving_count; k++)
        q->order[first[q->kind[k]]++] = k;
}

static rsv_specular_packet *packet_at(rsv_specular_queue *q, uint32_t index)
{
    rsv_specular_packet *p = &q->packet[index % RSV_STAGES];
    uint32_t first = index * LANES, left = q->moving_count - first;
    p->member = q->order + first;
    p->count = left < LANES ? left : LANES;
    return p;
}

/// All waiting paths take one step, with every packet one stage behind the one after it.
static void step(rsv_specular_queue *q)
{
    set_moving(q);
    uint32_t count = (q->moving_count + LANES - 1) / LANES;
    for (uint32_t n = 0; n < count + RSV_STAGES - 1; n++) {
        if (n < count) depart(q, packet_at(q, n));
        if (n >= 1 && n - 1 < count) locate(q, packet_at(q, n - 1));
        if (n >= 2 && n - 2 < count) descend(q, packet_at(q, n - 2));
        if (n >= 3) arrive(q, packet_at(q, n - 3));
    }
}

void rsv_specular_queue_run(rsv_specular_queue *q)
{
    while (q->waiting_count > 0)
        step(q);
}
