/// What assembly could cost at best: its rays, traced and forgotten.
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

rsv_status rsv_transport_trace_only(const rsv_transport_desc *desc, rsv_ray_cost *cost)
{
    const rsv_elements *elements = desc->elements;
    const rsv_tracer *tracer = desc->scene->tracer;
    rsv_context *context = elements->context;
    rsv_directions directions;
    uint32_t rays = desc->rays, seed = desc->seed;
    rsv_status status = rsv_directions_create(context, rays, seed, &directions);
    if (status != RSV_OK) return status;
    double packet_sum = 0, single_sum = 0;
    uint64_t traced = 0;
    bool failed = false;
#pragma omp parallel num_threads(rsv_threads(context)) reduction(+ : packet_sum, single_sum, traced)
    {
        rsv_ray_packet *packets = rsv_alloc(context, rays / LANES, sizeof *packets);
#pragma omp for schedule(dynamic, 64)
        for (size_t node = 0; node < rsv_elements_surface_nodes(elements); node++) {
            if (!packets || desc->valid_points[node] == 0) continue;
            rsv_receiver_draw draw = { (uint32_t)node,
                rsv_elements_draw_of(elements, (uint32_t)node), seed, desc->valid_points[node] };
            aim_row(elements, tracer, &directions, draw, packets);
            time_row(tracer, packets, rays / LANES, &packet_sum, &single_sum);
            traced += rays;
        }
        if (!packets) {
#pragma omp atomic write
            failed = true;
        }
        rsv_free(context, packets);
    }
    cost->rays = traced;
    cost->packet_seconds = packet_sum / rsv_threads(context);
    cost->single_seconds = single_sum / rsv_threads(context);
    rsv_directions_destroy(&directions);
    return failed ? RSV_ERROR_MEMORY : RSV_OK;
}
