#include "../core/parallel.h"
#include "reference_internal.h"
#include "resolvent/render.h"

/// Independent randomisations of a reading; their spread is its standard error.
#define GROUPS 32
/// Lower limit of stated relative errors, because sums pass through float.
#define SMALLEST_RELATIVE_ERROR 1e-6

static const char phase[] = "probe";

/// Mean irradiance of one group of paths.
typedef struct group_mean {
    double irradiance[3];
    uint64_t rejected; ///< paths that were not finite
} group_mean;

/// Where light is measured: anywhere, or at a surface, of which it enters as much as gets past the coat.
typedef struct receiver {
    rsv_body_point at; ///< anywhere: without a triangle
    bool on_surface;
    rsv_vec3 normal;   ///< that a surface receives by
    rsv_medium medium; ///< above it
    rsv_rgb
        connected; ///< W/m2 through mirrors and glass: the same for all paths; on surfaces, paths find it
} receiver;

static receiver receiver_of_probe(const rsv_path_tracer *tracer, const rsv_probe *probe)
{
    receiver r = { .at = { .point = probe->position, .geometric = v3_normalize(probe->normal) } };
    rsv_vec3 origin = rsv_tracer_receiver_origin(tracer->tracer, r.at.point, r.at.geometric);
    r.medium = rsv_medium_above(&tracer->media, origin, r.at.geometric);
    r.connected = rsv_connected_irradiance(tracer->connections, r.at.point, r.at.geometric, true);
    return r;
}

static receiver receiver_of_place(const rsv_path_tracer *tracer, const rsv_surface_place *place)
{
    rsv_surface_point p = rsv_surface_point_seen(
        tracer->scene, place->triangle, place->u, place->v, place->back, place->width);
    rsv_vec3 origin = rsv_offset_origin(p.position, p.geometric, p.extent);
    return (receiver){ .at = { p.position, p.geometric, place->triangle, place->u, place->v },
        .on_surface = true,
        .normal = p.normal,
        .medium = rsv_medium_above(&tracer->media, origin, p.geometric) };
}

static rsv_rgb trace_path(const rsv_path_tracer *tracer, const receiver *r, rsv_path_id id)
{
    rsv_path_light light;
    if (r->on_surface)
        rsv_trace_entering_path(tracer, r->at, r->normal, &r->medium, id, &light);
    else
        rsv_trace_receiver_path(tracer, r->at.point, r->at.geometric, &r->medium, id, &light);
    return rsv_path_light_total(&light);
}

static group_mean measure_group(
    const rsv_path_tracer *tracer, const receiver *r, uint32_t samples, uint32_t stream)
{
    group_mean group = { 0 };
    for (uint32_t i = 0; i < samples; i++) {
        rsv_rgb radiance = trace_path(tracer, r, (rsv_path_id){ i, stream });
        if (!isfinite(rgb_luminance(radiance))) {
            group.rejected++;
            continue;
        }
        double scale = (double)RSV_PI / samples;
        group.irradiance[0] += (double)radiance.r * scale;
        group.irradiance[1] += (double)radiance.g * scale;
        group.irradiance[2] += (double)radiance.b * scale;
    }
    return group;
}

/// @param connected added to all groups
static void summarise_channel(
    const group_mean *group, int channel, double connected, float *mean, float *error)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < GROUPS; i++)
        sum += group[i].irradiance[channel];
    double average = sum / GROUPS, all = average + connected;
    for (int i = 0; i < GROUPS; i++) {
        double deviation = group[i].irradiance[channel] - average;
        squares += deviation * deviation;
    }
    double spread = sqrt(squares / (GROUPS - 1) / GROUPS);
    *mean = (float)all;
    *error = (float)fmax(spread, SMALLEST_RELATIVE_ERROR * fabs(all));
}

static rsv_probe_reading summarise(const group_mean *group, rsv_rgb connected)
{
    rsv_probe_reading reading;
    summarise_channel(
        group, 0, (double)connected.r, &reading.irradiance.r, &reading.standard_error.r);
    summarise_channel(
        group, 1, (double)connected.g, &reading.irradiance.g, &reading.standard_error.g);
    summarise_channel(
        group, 2, (double)connected.b, &reading.irradiance.b, &reading.standard_error.b);
    return reading;
}

static rsv_status check_probe(const rsv_probe *probe, size_t index)
{
    rsv_vec3 p = probe->position, n = probe->normal;
    if (!isfinite(p.x + p.y + p.z) || !isfinite(n.x + n.y + n.z))
        return rsv_fail(RSV_ERROR_ARGUMENT, "probe %zu: position or normal is not finite", index);
    if (!(v3_length(n) > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "probe %zu: the normal has no length", index);
    return RSV_OK;
}

/// Groups, not probes, are shared out among threads: a single probe keeps all of them busy.
typedef struct group_job {
    const rsv_path_tracer *tracer;
    const receiver *receiver;
    uint32_t samples, seed;
    group_mean *group; ///< [count]
    size_t count;
    atomic_size_t done;
} group_job;

static void measure_groups(void *user, rsv_span span)
{
    group_job *job = user;
    rsv_context *context = job->tracer->context;
    for (size_t i = span.begin; i < span.end && !rsv_cancelled(context); i++) {
        size_t probe = i / GROUPS;
        uint32_t stream = rsv_hash3((uint32_t)probe, (uint32_t)(i % GROUPS), job->seed);
        job->group[i] = measure_group(job->tracer, &job->receiver[probe], job->samples, stream);
        rsv_item_done(context, phase, span.worker, &job->done, job->count);
    }
}

static void warn_of_rejected(rsv_context *context, const group_mean *groups, size_t count)
{
    uint64_t rejected = 0;
    for (size_t i = 0; i < count; i++)
        rejected += groups[i].rejected;
    if (rejected)
        rsv_log(context, RSV_LOG_WARNING, "probe: %llu paths were not finite and count as black",
            (unsigned long long)rejected);
}

typedef struct measurement {
    const rsv_probe *probe;
    const rsv_surface_place *place; ///< where there are no probes
    size_t count;
    uint32_t samples, seed;
} measurement;

static rsv_status measure(const rsv_scene *scene, const measurement *m, rsv_probe_reading *readings)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_path_tracer *tracer = NULL;
    uint32_t samples = m->samples / GROUPS + (m->samples % GROUPS != 0);
    receiver *receivers = rsv_alloc(context, m->count, sizeof *receivers);
    group_mean *groups = rsv_alloc(context, m->count, GROUPS * sizeof *groups);
    if (!receivers || !groups) goto cleanup;
    RSV_TRY(rsv_path_tracer_create(scene, true, &tracer));
    for (size_t i = 0; i < m->count; i++)
        receivers[i] = m->probe ? receiver_of_probe(tracer, &m->probe[i])
                                : receiver_of_place(tracer, &m->place[i]);
    group_job job = { tracer, receivers, samples, m->seed, groups, m->count * GROUPS, 0 };
    rsv_parallel_for(context, job.count, 1, measure_groups, &job);
    RSV_TRY(rsv_progress(context, phase, 1));
    for (size_t i = 0; i < m->count; i++)
        readings[i] = summarise(groups + i * GROUPS, receivers[i].connected);
    warn_of_rejected(context, groups, m->count * GROUPS);
cleanup:
    rsv_path_tracer_destroy(tracer);
    rsv_free(context, receivers);
    rsv_free(context, groups);
    return status;
}

rsv_status rsv_probe_reference(const rsv_scene *scene, const rsv_probe *probes, size_t probe_count,
    uint32_t samples, uint32_t seed, rsv_probe_reading *readings)
{
    if (samples == 0) return rsv_fail(RSV_ERROR_ARGUMENT, "probe: samples must be at least 1");
    for (size_t i = 0; i < probe_count; i++) {
        rsv_status status = check_probe(&probes[i], i);
        if (status != RSV_OK) return status;
    }
    return measure(scene,
        &(measurement){ .probe = probes, .count = probe_count, .samples = samples, .seed = seed },
        readings);
}

rsv_status rsv_surface_reference(const rsv_scene *scene, const rsv_surface_place *places,
    size_t count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings)
{
    return measure(scene,
        &(measurement){ .place = places, .count = count, .samples = samples, .seed = seed },
        readings);
}
