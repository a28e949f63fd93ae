/// Minimum cost of assembly: tracing its rays without using the results.
#include "../core/parallel.h"
#include "directions.h"
#include "receiver_points.h"
#include "transport.h"

#include <string.h>

#define LANES RSV_SUPPORT_POINTS

static void aim_row(const rsv_elements *elements, const rsv_tracer *tracer,
    const rsv_directions *directions, rsv_receiver_draw draw, rsv_ray_packet *packets)
{
    rsv_receiver_points points;
    rsv_support_point sample[LANES];
    rsv_receiver_points_choose(elements, draw, sample);
    rsv_receiver_points_set_up(elements, tracer, draw, sample, &points);
    size_t set = rsv_directions_of(directions, draw.seed, draw.node);
    for (uint32_t p = 0; p < directions->count / LANES; p++) {
        size_t first = set + (size_t)p * LANES;
        memset(packets[p].mask, 0xff, sizeof packets[p].mask);
        rsv_receiver_points_aim(&points, directions->x + first, directions->y + first,
            directions->z + first, &packets[p]);
    }
}

static void trace_singly(const rsv_tracer *tracer, const rsv_ray_packet *packet)
{
    for (int k = 0; k < LANES; k++) {
        rsv_hit hit;
        rsv_ray ray = { v3(packet->origin_x[k], packet->origin_y[k], packet->origin_z[k]),
            v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]), INFINITY };
        if (packet->t_max[k] > 0) rsv_tracer_closest(tracer, &ray, &hit);
    }
}

/// Seconds to trace packets that are aimed already.
static void time_row(const rsv_tracer *tracer, rsv_ray_packet *packets, uint32_t count,
    double *packet_seconds, double *single_seconds)
{
    double start = rsv_seconds();
    for (uint32_t p = 0; p < count; p++)
        trace_singly(tracer, &packets[p]);
    double middle = rsv_seconds();
    for (uint32_t p = 0; p < count; p++)
        rsv_tracer_closest_packet(tracer, &packets[p], false);
    *single_seconds += middle - start;
    *packet_seconds += rsv_seconds() - middle;
}

/// The rows of all nodes, which workers share.
typedef struct trace_job {
    const rsv_transport_desc *desc;
    rsv_directions directions;
    rsv_share nodes;
    atomic_uint_least64_t rays, packet_nanoseconds, single_nanoseconds;
    _Atomic rsv_status status;
} trace_job;

static void trace_rows(void *data, int worker)
{
    trace_job *job = data;
    const rsv_transport_desc *desc = job->desc;
    const rsv_elements *e = desc->elements;
    const rsv_tracer *tracer = desc->scene->tracer;
    double packet_seconds = 0, single_seconds = 0;
    rsv_ray_packet *packets = rsv_alloc(e->context, desc->rays / LANES, sizeof *packets);
    rsv_keep_failure(&job->status, packets ? RSV_OK : RSV_ERROR_MEMORY);
    for (rsv_span s; packets && rsv_share_take(&job->nodes, worker, &s);) {
        for (uint32_t node = (uint32_t)s.begin; node < s.end; node++) {
            if (desc->valid_points[node] == 0) continue;
            rsv_receiver_draw draw = { node, rsv_elements_draw_of(e, node), desc->seed,
                desc->valid_points[node] };
            aim_row(e, tracer, &job->directions, draw, packets);
            time_row(tracer, packets, desc->rays / LANES, &packet_seconds, &single_seconds);
            atomic_fetch_add(&job->rays, desc->rays);
        }
    }
    atomic_fetch_add(&job->packet_nanoseconds, (uint64_t)(1e9 * packet_seconds));
    atomic_fetch_add(&job->single_nanoseconds, (uint64_t)(1e9 * single_seconds));
    rsv_free(e->context, packets);
}

rsv_status rsv_transport_trace_only(const rsv_transport_desc *desc, rsv_ray_cost *cost)
{
    rsv_context *context = desc->elements->context;
    trace_job job = { .desc = desc,
        .nodes = rsv_share_of(rsv_elements_surface_nodes(desc->elements), 64) };
    rsv_status status = rsv_directions_create(context, desc->rays, desc->seed, &job.directions);
    if (status != RSV_OK) return status;
    rsv_parallel_workers(context, SIZE_MAX, trace_rows, &job);
    double share = 1e-9 / rsv_threads(context);
    cost->rays = job.rays;
    cost->packet_seconds = share * (double)job.packet_nanoseconds;
    cost->single_seconds = share * (double)job.single_nanoseconds;
    rsv_directions_destroy(&job.directions);
    return job.status;
}
