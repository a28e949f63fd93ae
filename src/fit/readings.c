#include "readings.h"

#include "../connect/connect.h"
#include "../core/parallel.h"
#include "../render/probe_gather.h"

#define GROUPS 32 ///< that rsv_probe_job.gather_rays counts for

typedef struct readings {
    const rsv_light_view *whole;
    const rsv_light_responses *responses;
    const rsv_fit_wanted *wanted;
    const rsv_fit_desc *desc;
    rsv_connections **connections; ///< [responses->count] of each light; NULL = nothing to connect
    rsv_rgb *reading;
    rsv_share points;
    _Atomic rsv_status result;
} readings;

static rsv_probe_job job_of(const readings *r, const rsv_light_view *view)
{
    return rsv_probe_job_of(view, r->desc->samples, r->desc->seed, true);
}

static rsv_probe_job job_of_light(const readings *r, size_t light)
{
    rsv_probe_job job = job_of(r, r->responses->view[light]);
    job.connections = r->connections[light];
    return job;
}

/// Light from all lights at one point, by shared rays.
static void read_ends(
    const readings *r, size_t point, const rsv_probe_end *end, size_t ends, rsv_rgb *reading)
{
    const rsv_probe *probe = &r->wanted[point].probe;
    for (size_t l = 0; l < r->responses->count; l++) {
        const rsv_light_view *view = r->responses->view[l];
        rsv_probe_job job = job_of_light(r, l);
        rsv_rgb sum = rsv_probe_direct(&job, probe, (uint32_t)point);
        for (size_t k = 0; k < ends; k++)
            sum = rgb_add(
                sum, rgb_mul(end[k].weight, rsv_light_view_irradiance(view, end[k].triangle,
                                                end[k].u, end[k].v, end[k].back, RSV_NONE)));
        reading[l] = sum;
    }
}

static void read_lights(const readings *r, size_t point, rsv_rgb *reading)
{
    for (size_t l = 0; l < r->responses->count; l++) {
        rsv_probe_job job = job_of_light(r, l);
        reading[l] = rsv_probe_read(&job, &r->wanted[point].probe, (uint32_t)point).irradiance;
    }
}

static void read_point(const readings *r, size_t point, rsv_probe_end *end)
{
    rsv_rgb *reading = r->reading + point * r->responses->count;
    rsv_probe_job job = job_of(r, r->whole);
    bool alone = false;
    size_t ends = rsv_probe_ends(&job, &r->wanted[point].probe, (uint32_t)point, end, &alone);
    if (alone)
        read_lights(r, point, reading);
    else
        read_ends(r, point, end, ends, reading);
}

static rsv_status connect_lights(readings *r)
{
    rsv_status status = RSV_OK;
    for (size_t l = 0; l < r->responses->count && status == RSV_OK; l++) {
        const rsv_light_view *view = r->responses->view[l];
        status = rsv_connections_create(&view->scene, view->lights, &r->connections[l]);
    }
    return status;
}

static void read_share(void *data, int worker)
{
    readings *r = data;
    rsv_context *context = r->whole->context;
    size_t ends = (size_t)GROUPS * job_of(r, r->whole).gather_rays;
    rsv_probe_end *end = rsv_alloc(context, ends, sizeof *end);
    if (!end) rsv_keep_failure(&r->result, RSV_ERROR_MEMORY);
    for (rsv_span span; r->result == RSV_OK && rsv_share_take(&r->points, worker, &span);)
        if (!rsv_cancelled(context)) read_point(r, span.begin, end);
    rsv_free(context, end);
}

static rsv_status read_points(readings *r, size_t count)
{
    rsv_context *context = r->whole->context;
    r->points = rsv_share_of(count, 1);
    rsv_parallel_workers(context, count, read_share, r);
    return r->result == RSV_OK ? rsv_progress(context, "fit", 1) : r->result;
}

rsv_status rsv_fit_read(const rsv_light_view *whole, const rsv_light_responses *responses,
    const rsv_fit_wanted *wanted, size_t count, const rsv_fit_desc *desc, rsv_rgb *reading)
{
    readings r = {
        .whole = whole, .responses = responses, .wanted = wanted, .desc = desc, .reading = reading
    };
    rsv_context *context = whole->context;
    rsv_status status;
    r.connections = rsv_alloc(context, responses->count, sizeof *r.connections);
    RSV_TRY(r.connections ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(connect_lights(&r));
    RSV_TRY(read_points(&r, count));
cleanup:
    for (size_t l = 0; r.connections && l < responses->count; l++)
        rsv_connections_destroy(r.connections[l]);
    rsv_free(context, r.connections);
    return status;
}
