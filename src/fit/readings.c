#include "readings.h"

#include "../connect/connect.h"
#include "../core/parallel.h"
#include "../render/probe_gather.h"
#include "../solve/light_sum.h"

#define GROUPS 32 ///< that rsv_probe_job.gather_rays counts for

typedef struct readings {
    const rsv_light_view *whole;
    const rsv_light_responses *responses;
    const rsv_fit_wanted *wanted;
    const rsv_fit_desc *desc;
    rsv_connections **connections; ///< [responses->count] of each light; NULL = nothing to connect
    rsv_probe_job all, *job;       ///< of all lights, and [responses->count] of each
    rsv_rgb *reading;
    rsv_share points;
    _Atomic rsv_status result;
} readings;

/// Light from all lights at one point, by shared rays.
static void read_ends(const readings *r, size_t point, const rsv_light_sum *ends, rsv_rgb *reading)
{
    for (size_t l = 0; l < r->responses->count; l++)
        reading[l] = rgb_add(rsv_probe_direct(&r->job[l], &r->wanted[point].probe, (uint32_t)point),
            rsv_light_sum_of(ends, r->responses->view[l]));
}

static void read_lights(const readings *r, size_t point, rsv_rgb *reading)
{
    for (size_t l = 0; l < r->responses->count; l++)
        reading[l] =
            rsv_probe_read(&r->job[l], &r->wanted[point].probe, (uint32_t)point).irradiance;
}

/// For one worker.
typedef struct scratch {
    rsv_probe_end *end; ///< [rays of a reading]
    rsv_light_sum sum;
} scratch;

static void read_point(const readings *r, size_t point, scratch *s)
{
    rsv_rgb *reading = r->reading + point * r->responses->count;
    bool alone = false;
    size_t ends = rsv_probe_ends(&r->all, &r->wanted[point].probe, (uint32_t)point, s->end, &alone);
    if (alone) {
        read_lights(r, point, reading);
        return;
    }
    s->sum.added = 0;
    for (size_t k = 0; k < ends; k++)
        rsv_light_sum_add(&s->sum, r->whole,
            &(rsv_triangle_point){ s->end[k].triangle, s->end[k].u, s->end[k].v, s->end[k].back },
            s->end[k].weight);
    rsv_light_sum_close(&s->sum, r->whole);
    read_ends(r, point, &s->sum, reading);
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

static void plan_jobs(readings *r)
{
    r->all = rsv_probe_job_of(r->whole, r->desc->samples, r->desc->seed, true);
    for (size_t l = 0; l < r->responses->count; l++) {
        r->job[l] = rsv_probe_job_of(r->responses->view[l], r->desc->samples, r->desc->seed, true);
        r->job[l].connections = r->connections[l];
    }
}

static void read_share(void *data, int worker)
{
    readings *r = data;
    rsv_context *context = r->whole->context;
    size_t ends = (size_t)GROUPS * r->all.gather_rays;
    scratch s = { .end = rsv_alloc(context, ends, sizeof *s.end) };
    rsv_status status = rsv_light_sum_create(context, ends, &s.sum);
    if (status != RSV_OK || !s.end) rsv_keep_failure(&r->result, RSV_ERROR_MEMORY);
    for (rsv_span span; r->result == RSV_OK && rsv_share_take(&r->points, worker, &span);)
        if (!rsv_cancelled(context)) read_point(r, span.begin, &s);
    rsv_light_sum_destroy(context, &s.sum);
    rsv_free(context, s.end);
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
    r.job = rsv_alloc(context, responses->count, sizeof *r.job);
    RSV_TRY(r.connections && r.job ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(connect_lights(&r));
    plan_jobs(&r);
    RSV_TRY(read_points(&r, count));
cleanup:
    for (size_t l = 0; r.connections && l < responses->count; l++)
        rsv_connections_destroy(r.connections[l]);
    rsv_free(context, r.connections);
    rsv_free(context, r.job);
    return status;
}
