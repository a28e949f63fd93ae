#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "importance.h"

#include <string.h>

void rsv_daylight_desc_init(rsv_daylight_desc *desc, size_t size, rsv_quality quality)
{
    static const uint32_t sensor_rays[] = { 15360, 61440, 245760 }, node_rays[] = { 240, 480, 960 };
    int q = quality > RSV_QUALITY_HIGH ? RSV_QUALITY_HIGH : (int)quality;
    const rsv_daylight_desc defaults = { .size = sizeof defaults,
        .ground_albedo = 0.2f,
        .subdivision = 4,
        .sensor_rays = sensor_rays[q],
        .node_rays = node_rays[q] };
    rsv_desc_fill(desc, size, &defaults);
}

static rsv_status check_desc(const rsv_probe *sensor, size_t count, const rsv_daylight_desc *desc)
{
    if (count == 0) return rsv_fail(RSV_ERROR_ARGUMENT, "daylight: there are no sensors");
    if (!isfinite(desc->north))
        return rsv_fail(RSV_ERROR_ARGUMENT, "daylight: north is not finite");
    if (!(desc->ground_albedo >= 0 && desc->ground_albedo <= 1))
        return rsv_fail(RSV_ERROR_ARGUMENT, "daylight: the ground's albedo is not within 0 to 1");
    for (size_t k = 0; k < count; k++) {
        rsv_vec3 p = sensor[k].position, n = sensor[k].normal;
        if (!isfinite(p.x + p.y + p.z) || !(v3_length(n) > 0) || !isfinite(v3_length(n)))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "daylight: sensor %zu: position and normal must be finite, the normal not zero", k);
    }
    return RSV_OK;
}

static rsv_status reserve(rsv_daylight *d, const rsv_probe *sensor)
{
    size_t count = d->sensor_count;
    d->sensor = rsv_alloc(d->context, count, sizeof *d->sensor);
    d->all = rsv_alloc(d->context, count * d->patches.count, sizeof *d->all);
    d->bent = rsv_alloc(d->context, count * d->patches.count, sizeof *d->bent);
    d->stored_error = rsv_alloc(d->context, count, sizeof *d->stored_error);
    d->buried = rsv_alloc(d->context, count, sizeof *d->buried);
    if (!d->sensor || !d->all || !d->bent || !d->stored_error || !d->buried)
        return RSV_ERROR_MEMORY;
    memcpy(d->sensor, sensor, count * sizeof *sensor);
    return RSV_OK;
}

/// Adds up direct and other light, with the mean of the reflected part.
/// @param reflected [patches.count] of that part only
static void complete_sensor(const rsv_daylight *d, rsv_patch_share *all, rsv_patch_share *bent,
    const rsv_patch_share *reflected)
{
    for (uint32_t p = 0; p < d->patches.count; p++) {
        float mean = 0;
        for (int g = 0; g < RSV_DAYLIGHT_GROUPS; g++) {
            bent[p].column[g] += reflected[p].column[g];
            all[p].column[g] += bent[p].column[g];
            mean += reflected[p].column[g] / RSV_DAYLIGHT_GROUPS;
        }
        all[p].column[RSV_DAYLIGHT_GROUPS] = bent[p].column[RSV_DAYLIGHT_GROUPS] = mean;
    }
}

/// State kept from one block of sensors to the next.
typedef struct coefficient_job {
    rsv_daylight *daylight;
    const rsv_stored_noise *noise;
    const rsv_node_escapes *escapes;
    rsv_transport_map *map;
    bool gray;                  ///< the operator treats all channels alike
    size_t first;               ///< sensor of the block
    rsv_importance importance;  ///< of the block's sensors
    rsv_patch_share *reflected; ///< [sensors of the block * patches.count]
    rsv_sensor_rays rays[RSV_SENSOR_BLOCK];
} coefficient_job;

static void trace_sensors(void *data, rsv_span span)
{
    coefficient_job *job = data;
    rsv_daylight *d = job->daylight;
    size_t nodes = d->light->elements->node_count;
    for (size_t f = span.begin; f < span.end; f++) {
        size_t s = job->first + f, at = s * d->patches.count;
        job->rays[f] = (rsv_sensor_rays){ .straight = d->all + at,
            .bent = d->bent + at,
            .weight = job->importance.weight + f * nodes };
        if (rsv_cancelled(d->context)) continue;
        rsv_sensor_rays_trace(d, job->noise, s, &job->rays[f]);
        d->stored_error[s] = job->rays[f].stored_error;
        d->buried[s] = job->rays[f].buried;
    }
}

static void complete_sensors(void *data, rsv_span span)
{
    const coefficient_job *job = data;
    const rsv_daylight *d = job->daylight;
    for (size_t f = span.begin; f < span.end; f++) {
        size_t at = (job->first + f) * d->patches.count;
        rsv_patch_share *reflected = job->reflected + f * d->patches.count;
        rsv_importance_add(&job->importance, job->escapes, f, &job->rays[f], reflected);
        complete_sensor(d, d->all + at, d->bent + at, reflected);
    }
}

static rsv_status find_block(coefficient_job *job, size_t first, size_t count)
{
    rsv_daylight *d = job->daylight;
    rsv_status status;
    job->first = first;
    job->reflected = rsv_alloc(d->context, count * d->patches.count, sizeof *job->reflected);
    RSV_TRY(job->reflected ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_importance_create(d, count, &job->importance));
    rsv_parallel_for(d->context, count, 1, trace_sensors, job);
    RSV_TRY(rsv_importance_solve(d, job->map, job->gray, &job->importance));
    rsv_parallel_for(d->context, count, 1, complete_sensors, job);
    RSV_TRY(rsv_progress(d->context, "sky", 1));
cleanup:
    rsv_importance_destroy(d, &job->importance);
    rsv_free(d->context, job->reflected);
    return status;
}

static rsv_status find_coefficients(rsv_daylight *d)
{
    rsv_stored_noise noise = { 0 };
    rsv_node_escapes escapes = { 0 };
    coefficient_job job = { .daylight = d, .noise = &noise, .escapes = &escapes };
    rsv_status status;
    RSV_TRY(rsv_stored_noise_create(d->light, false, &noise));
    RSV_TRY(rsv_node_escapes_find(d, &escapes));
    job.gray = rsv_operator_is_gray(d->light->op);
    size_t block = job.gray ? RSV_SENSOR_BLOCK : RSV_SENSOR_FIELDS;
    RSV_TRY(rsv_operator_map(d->light->op, block, &job.map));
    RSV_TRY(rsv_transport_map_transpose(job.map));
    for (size_t first = 0; first < d->sensor_count; first += block) {
        size_t left = d->sensor_count - first;
        rsv_progress_part(d->context, "sensors", (uint32_t)(first / block + 1));
        RSV_TRY(find_block(&job, first, left < block ? left : block));
    }
cleanup:
    rsv_progress_part(d->context, NULL, 0);
    rsv_transport_map_destroy(job.map);
    rsv_node_escapes_free(d->context, &escapes);
    rsv_stored_noise_destroy(&noise);
    return status;
}

rsv_status rsv_daylight_create(const rsv_light *light, const rsv_probe *sensor, size_t count,
    const rsv_daylight_desc *desc, rsv_daylight **daylight)
{
    const rsv_light_view *view = rsv_light_get_view(light);
    rsv_daylight_desc settings = rsv_default_daylight_desc(RSV_QUALITY_MEDIUM);
    rsv_status status = RSV_READ_DESC(rsv_daylight_desc, &settings, desc);
    *daylight = NULL;
    if (status == RSV_OK) status = check_desc(sensor, count, &settings);
    if (status == RSV_OK && view->scene.view->fog)
        status = rsv_fail(
            RSV_ERROR_UNSUPPORTED, "daylight: fog is not supported; remove it from the scene");
    if (status != RSV_OK) return status;
    rsv_daylight *d = rsv_alloc(view->context, 1, sizeof *d);
    if (!d) return RSV_ERROR_MEMORY;
    d->context = view->context;
    d->light = view;
    d->desc = settings;
    d->patches = rsv_sky_patches_of(settings.subdivision);
    d->north[0] = cos(settings.north * M_PI / 180);
    d->north[1] = sin(settings.north * M_PI / 180);
    d->sensor_count = count;
    RSV_TRY(reserve(d, sensor));
    RSV_TRY(find_coefficients(d));
    *daylight = d;
cleanup:
    if (status != RSV_OK) rsv_daylight_destroy(d);
    return status;
}

void rsv_daylight_destroy(rsv_daylight *d)
{
    if (!d) return;
    rsv_free(d->context, d->sensor);
    rsv_free(d->context, d->all);
    rsv_free(d->context, d->bent);
    rsv_free(d->context, d->stored_error);
    rsv_free(d->context, d->buried);
    rsv_free(d->context, d);
}

size_t rsv_daylight_sensor_count(const rsv_daylight *d) { return d->sensor_count; }

bool rsv_daylight_is_buried(const rsv_daylight *d, size_t sensor) { return d->buried[sensor]; }

double rsv_daylight_coefficient(const rsv_daylight *d, size_t sensor, uint32_t patch)
{
    const float *column = d->all[sensor * d->patches.count + patch].column;
    double sum = 0;
    for (int g = 0; g < RSV_DAYLIGHT_GROUPS; g++)
        sum += (double)column[g];
    return sum / RSV_DAYLIGHT_GROUPS;
}
