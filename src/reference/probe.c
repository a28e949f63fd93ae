#include "../core/core.h"
#include "reference_internal.h"
#include "resolvent/render.h"

/// Independent randomisations of a reading; their spread is its standard error.
#define GROUPS 32
/// No reading is claimed to be better than this: its sums pass through float.
#define SMALLEST_RELATIVE_ERROR 1e-6

static const char phase[] = "probe";

/// Mean irradiance of one group of paths.
typedef struct group_mean {
    double irradiance[3];
    uint64_t rejected; ///< paths that were not finite
} group_mean;

static group_mean measure_group(const rsv_path_tracer *tracer, rsv_vec3 point, rsv_vec3 normal,
    uint32_t samples, uint32_t stream)
{
    group_mean group = { 0 };
    rsv_vec3 origin = rsv_tracer_receiver_origin(tracer->tracer, point, normal);
    rsv_medium medium = rsv_medium_above(&tracer->media, origin, normal);
    for (uint32_t i = 0; i < samples; i++) {
        rsv_path_light light;
        rsv_trace_receiver_path(tracer, point, normal, &medium, (rsv_path_id){ i, stream }, &light);
        rsv_rgb radiance = rsv_path_light_total(&light);
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

static void summarise_channel(const group_mean *group, int channel, float *mean, float *error)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < GROUPS; i++)
        sum += group[i].irradiance[channel];
    double average = sum / GROUPS;
    for (int i = 0; i < GROUPS; i++) {
        double deviation = group[i].irradiance[channel] - average;
        squares += deviation * deviation;
    }
    double spread = sqrt(squares / (GROUPS - 1) / GROUPS);
    *mean = (float)average;
    *error = (float)fmax(spread, SMALLEST_RELATIVE_ERROR * fabs(average));
}

static rsv_probe_reading summarise(const group_mean *group)
{
    rsv_probe_reading reading;
    summarise_channel(group, 0, &reading.irradiance.r, &reading.standard_error.r);
    summarise_channel(group, 1, &reading.irradiance.g, &reading.standard_error.g);
    summarise_channel(group, 2, &reading.irradiance.b, &reading.standard_error.b);
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
static rsv_status measure_groups(const rsv_path_tracer *tracer, const rsv_probe *probes,
    size_t probe_count, uint32_t samples, uint32_t seed, group_mean *groups)
{
    rsv_context *context = tracer->context;
    size_t total = probe_count * GROUPS, groups_done = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(context))
    for (size_t i = 0; i < total; i++) {
        if (rsv_cancelled(context)) continue;
        size_t probe = i / GROUPS;
        rsv_vec3 normal = v3_normalize(probes[probe].normal);
        uint32_t stream = rsv_hash3((uint32_t)probe, (uint32_t)(i % GROUPS), seed);
        groups[i] = measure_group(tracer, probes[probe].position, normal, samples, stream);
        size_t done;
#pragma omp atomic capture
        done = ++groups_done;
        rsv_poll_progress(context, phase, done, total);
    }
    return rsv_progress(context, phase, 1);
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

rsv_status rsv_probe_reference(const rsv_scene *scene, const rsv_probe *probes, size_t probe_count,
    uint32_t samples, uint32_t seed, rsv_probe_reading *readings)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_path_tracer *tracer = NULL;
    group_mean *groups = NULL;
    if (samples == 0) RSV_TRY(rsv_fail(RSV_ERROR_ARGUMENT, "probe: samples must be at least 1"));
    for (size_t i = 0; i < probe_count; i++)
        RSV_TRY(check_probe(&probes[i], i));
    groups = rsv_alloc(context, probe_count, GROUPS * sizeof *groups);
    if (!groups) RSV_TRY(RSV_ERROR_MEMORY);
    RSV_TRY(rsv_path_tracer_create(scene, &tracer));
    uint32_t samples_per_group = samples / GROUPS + (samples % GROUPS != 0);
    RSV_TRY(measure_groups(tracer, probes, probe_count, samples_per_group, seed, groups));
    for (size_t i = 0; i < probe_count; i++)
        readings[i] = summarise(groups + i * GROUPS);
    warn_of_rejected(context, groups, probe_count * GROUPS);
cleanup:
    rsv_path_tracer_destroy(tracer);
    rsv_free(context, groups);
    return status;
}
