/// Irradiance at virtual receivers: next-event estimation plus one gather through the solution.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../core/stratified.h"
#include "../receiver/next_event.h"
#include "../solve/goal.h"
#include "../solve/light.h"
#include "../sources/partition.h"
#include "fog_light.h"
#include "lit_gather.h"
#include "pixel_direct.h"
#include "probe_gather.h"
#include "resolvent/render.h"

#define GROUPS 32 ///< independent randomisations: their spread is the standard error
/// Rounding of the inputs and of the sums, relative; no standard error is reported below it.
#define ROUNDING 1e-6
/// Sources that cover a larger share of the scene are found by gather rays even behind glass and mirrors.
#define LARGE_SOURCE_SHARE 0.02

typedef struct receiver {
    rsv_receiver at;
    rsv_medium medium;
    rsv_rgb
        caustic; ///< stored, if the receiver is on a surface; otherwise only of punctual lights
    bool has_caustic; ///< it is the stored one
    const rsv_probe_job *job;
    double variance; ///< of the luminance of `caustic`
    rsv_shared_noise shared;
} receiver;

static bool all_sources_large(const rsv_light_view *s)
{
    double total = 0;
    for (size_t t = 0; t < s->scene.view->triangle_count; t++)
        total += rsv_triangle_area(s->scene.view, (uint32_t)t);
    for (size_t g = 0; g < s->lights->group_count; g++)
        if (s->lights->group[g].area < LARGE_SOURCE_SHARE * total) return false;
    return s->scene.view->light_count == 0;
}

/// A receiver that lies on a surface takes the caustic light stored there.
static void find_surface(receiver *r)
{
    const rsv_light_view *s = r->job->solution;
    float lift = v3_length(v3_sub(r->at.origin, r->at.point.position));
    rsv_ray ray = { r->at.origin, v3_neg(r->at.point.normal), 4 * lift };
    rsv_hit hit;
    if (!s->caustics.caustic || r->job->gather_caustics ||
        !rsv_tracer_closest(s->tracer, &ray, &hit))
        return;
    rsv_specular_path path = rsv_specular_begin(&s->scene, NULL, ray.direction, hit);
    uint32_t face = s->elements->face_of[path.back][hit.triangle];
    rsv_surface_point point =
        rsv_surface_point_at(s->scene.view, hit.triangle, hit.u, hit.v, path.back);
    const rsv_bsdf *bsdf = &s->bsdf[s->scene.view->triangle_material[hit.triangle]];
    // stored light is that which enters this surface, and is useful for receivers that are flat on it
    if (face == RSV_NONE || bsdf->coated || v3_dot(point.normal, r->at.point.normal) < 0.999f)
        return;
    r->caustic =
        rsv_elements_interpolate(s->caustics.elements, s->caustics.caustic, face, hit.u, hit.v);
    if (r->job->noise) r->variance = rsv_stored_noise_at(r->job->noise, face, hit.u, hit.v, true);
    r->has_caustic = true;
}

static receiver set_up_receiver(const rsv_probe_job *job, const rsv_probe *probe)
{
    receiver r = { .job = job };
    rsv_vec3 position = probe->position, normal = v3_normalize(probe->normal);
    r.at = rsv_receiver_in_space(
        position, normal, rsv_tracer_receiver_origin(job->solution->tracer, position, normal));
    r.medium = rsv_medium_above(&job->solution->scene.media, r.at.origin, normal);
    find_surface(&r);
    if (!r.has_caustic)
        r.caustic = rsv_connected_irradiance(job->connections, position, normal, false);
    return r;
}

/// @param share of the whole that one event is
static rsv_entrance entrance_of(const receiver *r, float share)
{
    rsv_entrance e = rsv_entrance_through(&r->medium, r->job->solution->bsdf, RSV_COVER_NONE);
    e.weight = rgb_gray(share);
    return e;
}

static rsv_event_sums sample_emitters(
    const receiver *r, const rsv_local_lights *local, uint32_t stream)
{
    uint32_t count = r->job->light_samples;
    rsv_event_sums sums = rsv_event_sums_zero();
    rsv_entrance entrance = entrance_of(r, 1 / (float)count);
    for (uint32_t k = 0; k < count; k++) {
        float u[3] = { rsv_stratified_1d(k, count, rsv_hash2(stream, 1)), 0, 0 };
        rsv_sobol_2d(k, rsv_hash2(stream, 2), &u[1], &u[2]);
        rsv_next_event event;
        rsv_next_event_draw(&r->at, &entrance, local, u, &event);
        rsv_event_sums_add(&sums, &event, rsv_next_event_passed(r->job->solution->tracer, &event));
    }
    return sums;
}

/// One channel of each group's estimate: unshadowed irradiance in closed form times sampled visibility, as at
/// the elements. The ratio is taken over all groups together (a ratio of few samples is biased) and linearised
/// for each.
static void ratio_estimates(
    float exact, const float visible[GROUPS], const float open[GROUPS], double value[GROUPS])
{
    double all_visible = 0, all_open = 0;
    for (int g = 0; g < GROUPS; g++) {
        all_visible += visible[g];
        all_open += open[g];
    }
    if (!(all_open > 0)) return;
    double share = all_visible / all_open;
    for (int g = 0; g < GROUPS; g++)
        value[g] += exact * (share + (visible[g] - share * open[g]) * GROUPS / all_open);
}

/// Adds the light of the emitters to each group's reading.
static void add_emitters(const receiver *r, uint32_t index, double value[3][GROUPS])
{
    const rsv_lights *lights = r->job->solution->lights;
    if (!rsv_lights_any_sampled(lights)) return;
    rsv_local_lights local;
    rsv_receiver_weigh(&r->at, lights, &local);
    if (rsv_local_lights_are_dark(&local)) return;
    float visible[3][GROUPS], open[3][GROUPS];
    for (uint32_t g = 0; g < GROUPS; g++) {
        rsv_event_sums sums =
            sample_emitters(r, &local, rsv_hash(rsv_hash3(r->job->seed, index, g)));
        visible[0][g] = sums.visible.r, visible[1][g] = sums.visible.g,
        visible[2][g] = sums.visible.b;
        open[0][g] = sums.open.r, open[1][g] = sums.open.g, open[2][g] = sums.open.b;
        value[0][g] += sums.further.r, value[1][g] += sums.further.g, value[2][g] += sums.further.b;
    }
    const float exact[3] = { local.unshadowed.r, local.unshadowed.g, local.unshadowed.b };
    for (int c = 0; c < 3; c++)
        ratio_estimates(exact[c], visible[c], open[c], value[c]);
}

/// Adds the light of punctual sources to each group's reading: the same to all, unless lights are drawn.
static void add_punctual(const receiver *r, uint32_t index, double value[3][GROUPS])
{
    const rsv_light_view *s = r->job->solution;
    bool drawn = s->lights->punctual_tree || s->lights->extended;
    uint32_t count = drawn ? r->job->light_samples : 1;
    rsv_rgb sum = rgb_gray(0);
    rsv_entrance entrance = entrance_of(r, 1);
    uint64_t rays = 0;
    for (uint32_t g = 0; g < GROUPS; g++) {
        uint32_t stream = rsv_hash(rsv_hash3(r->job->seed, index, g) + 1);
        if (g == 0 || count > 1) sum = rgb_gray(0);
        for (uint32_t k = 0; k < count && (g == 0 || count > 1); k++)
            sum = rgb_mad(sum, 1 / (float)count,
                rsv_punctual_irradiance_at(&r->at, &entrance, s->lights, s->tracer,
                    rsv_stratified_1d(k, count, stream), &rays));
        value[0][g] += sum.r, value[1][g] += sum.g, value[2][g] += sum.b;
    }
}

/// Records a ray's lookup, for the standard error.
static void note_stored(
    receiver *r, const rsv_specular_path *end, uint32_t face, const rsv_bsdf *bsdf, rsv_rgb stored)
{
    if (!r->job->noise) return;
    float share = rgb_luminance(rgb_mul(end->weight, bsdf->base_color));
    float rays = (float)(GROUPS * r->job->gather_rays);
    const rsv_stored_lookup found = { face, end->u, end->v, share / rays, rgb_luminance(stored) };
    rsv_shared_noise_add(&r->shared, r->job->noise, &found);
}

static rsv_rgb gather_one(receiver *r, rsv_vec3 direction, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    rsv_ray ray = { r->at.origin, direction, INFINITY };
    // the stored caustic includes the light of photons
    const rsv_lit_setting setting = { &s->scene, s->lights, r->has_caustic };
    rsv_gather gather = rsv_gather_lit_ray(&setting, &r->medium, &ray, random);
    rsv_rgb radiance = gather.emission;
    if (gather.end == RSV_SPECULAR_SCATTERED)
        return rgb_add(
            radiance, rgb_mul(gather.path.weight, rsv_fog_radiance_at(s, gather.place, random)));
    if (gather.end != RSV_SPECULAR_DIFFUSE) return radiance;
    const rsv_specular_path *end = &gather.path;
    uint32_t face = s->elements->face_of[end->back][end->triangle];
    if (face == RSV_NONE) return radiance;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, end, &storage);
    if (rsv_is_translucent(s, face)) {
        rsv_rgb diffused = rgb_add(rsv_light_view_diffused(s, face, end->u, end->v, 0),
            rsv_light_view_diffused(s, face, end->u, end->v, RSV_NONE));
        rsv_rgb exitance = rgb_mul(bsdf->base_color, diffused);
        note_stored(r, end, face, bsdf, diffused);
        return rgb_mad(radiance, 1 / RSV_PI, rgb_mul(end->weight, exitance));
    }
    // Direct light at the far end is sampled there, because what elements do not resolve must not affect a reading. All
    // further light is looked up.
    rsv_rgb stored = rgb_add(rsv_light_view_direct(s, face, end->u, end->v, true),
        rsv_elements_interpolate(s->elements, s->indirect, face, end->u, end->v));
    note_stored(r, end, face, bsdf, stored);
    rsv_rgb irradiance = rgb_add(stored, rsv_sampled_irradiance(s, end, random));
    rsv_rgb exitance = rgb_mul(bsdf->base_color, irradiance);
    return rgb_mad(radiance, 1 / RSV_PI, rgb_mul(end->weight, exitance));
}

static rsv_rgb gather(receiver *r, uint32_t stream)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < r->job->gather_rays; k++) {
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_random random = rsv_random_from(stream, k, 0x2f6u);
        rsv_vec3 direction = v3_turned_to(r->at.point.normal, d);
        sum = rgb_add(sum, gather_one(r, direction, &random));
    }
    return rgb_scale(sum, RSV_PI / (float)r->job->gather_rays);
}

/// Added to the variance for each event that it rests on: a rare one, such as a lamp that few rays find in a mirror, is
/// found less often than its mean in most readings, whose groups then differ too little.
#define RARE_EVENT 1.25
/// Kurtosis of values that rest on many events.
#define NORMAL_KURTOSIS 3

/// Mean and standard error of the groups' readings.
static void summarise(const double value[GROUPS], float *mean, float *error)
{
    double sum = 0, squares = 0, fourths = 0;
    for (int g = 0; g < GROUPS; g++)
        sum += value[g];
    for (int g = 0; g < GROUPS; g++) {
        double square = (value[g] - sum / GROUPS) * (value[g] - sum / GROUPS);
        squares += square;
        fourths += square * square;
    }
    // 1 / number of events; for equal values except one, it is 1
    double events = squares > 0 ? fourths / (squares * squares) : 0;
    double rare = RARE_EVENT * fmax(events - (double)NORMAL_KURTOSIS / GROUPS, 0);
    double variance = squares * (1 + rare) / (GROUPS * (GROUPS - 1.0));
    *mean = (float)(sum / GROUPS);
    *error = (float)fmax(sqrt(variance), ROUNDING * fabs(sum / GROUPS));
}

/// @param variance of the luminance: each channel errs by as large a share
static void add_stored_noise(rsv_probe_reading *reading, double variance)
{
    double luminance = (double)rgb_luminance(reading->irradiance);
    double square = luminance > 0 ? variance / (luminance * luminance) : 0;
    float *error = &reading->standard_error.r;
    const float *value = &reading->irradiance.r;
    for (int c = 0; c < 3; c++) {
        double own = (double)error[c], stored = (double)value[c];
        error[c] = (float)sqrt(own * own + square * stored * stored);
    }
}

rsv_probe_reading rsv_probe_read(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index)
{
    receiver r = set_up_receiver(job, probe);
    double value[3][GROUPS];
    for (uint32_t g = 0; g < GROUPS; g++) {
        rsv_rgb e = rgb_add(r.caustic, gather(&r, rsv_hash3(job->seed, index, g)));
        value[0][g] = e.r, value[1][g] = e.g, value[2][g] = e.b;
    }
    if (job->sources) {
        add_emitters(&r, index, value);
        add_punctual(&r, index, value);
    }
    rsv_probe_reading reading;
    summarise(value[0], &reading.irradiance.r, &reading.standard_error.r);
    summarise(value[1], &reading.irradiance.g, &reading.standard_error.g);
    summarise(value[2], &reading.irradiance.b, &reading.standard_error.b);
    if (job->noise)
        add_stored_noise(&reading, r.variance + rsv_shared_noise_variance(&r.shared, job->noise));
    return reading;
}

// ---- once for many lights -------------------------------------------------------------------------

/// @return whether there is an end
static bool find_end(
    const receiver *r, rsv_vec3 direction, rsv_random *random, rsv_probe_end *end, bool *alone)
{
    const rsv_light_view *s = r->job->solution;
    rsv_ray ray = { r->at.origin, direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(s->tracer, &ray, &hit)) {
        *alone = *alone || s->lights->environment;
        return false;
    }
    rsv_specular_path first = rsv_specular_begin(&s->scene, &r->medium, direction, hit);
    const rsv_lit_setting setting = { &s->scene, s->lights, r->has_caustic };
    rsv_gather gather = rsv_gather_lit(&setting, first, random);
    const rsv_specular_path *path = &gather.path;
    *alone = *alone || !rgb_is_black(gather.emission);
    if (gather.end != RSV_SPECULAR_DIFFUSE) return false;
    uint32_t face = s->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return false;
    *alone = *alone || rsv_is_translucent(s, face);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, path, &storage);
    *end = (rsv_probe_end){ path->triangle, path->u, path->v, path->back,
        rgb_mul(path->weight, bsdf->base_color) };
    return true;
}

size_t rsv_probe_ends(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index,
    rsv_probe_end *end, bool *alone)
{
    receiver r = set_up_receiver(job, probe);
    uint32_t rays = GROUPS * job->gather_rays, stream = rsv_hash3(job->seed, index, 0);
    size_t count = 0;
    for (uint32_t k = 0; k < rays; k++) {
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_random random = rsv_random_from(stream, k, 0x2f6u);
        rsv_vec3 direction = v3_turned_to(r.at.point.normal, d);
        if (!find_end(&r, direction, &random, &end[count], alone)) continue;
        end[count].weight = rgb_scale(end[count].weight, 1 / (float)rays);
        count++;
    }
    return count;
}

rsv_rgb rsv_probe_direct(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index)
{
    receiver r = set_up_receiver(job, probe);
    double value[3][GROUPS] = { { 0 } }, sum[3] = { 0 };
    add_emitters(&r, index, value);
    add_punctual(&r, index, value);
    for (int c = 0; c < 3; c++)
        for (int g = 0; g < GROUPS; g++)
            sum[c] += value[c][g] / GROUPS;
    return rgb_add(r.caustic, rgb((float)sum[0], (float)sum[1], (float)sum[2]));
}

rsv_probe_job rsv_probe_job_of(
    const rsv_light_view *solution, uint32_t samples, uint32_t seed, bool sources)
{
    uint32_t per_group = samples / GROUPS + (samples % GROUPS != 0);
    if (per_group < 2) per_group = 2;
    return (rsv_probe_job){ solution, per_group, per_group / 4 < 4 ? 4 : per_group / 4, seed,
        all_sources_large(solution), sources, NULL, NULL };
}

static rsv_probe_reading look_up(
    const rsv_light_view *s, const rsv_stored_noise *noise, const rsv_probe *probe)
{
    rsv_probe_reading reading = { 0 };
    rsv_hit hit;
    if (!rsv_tracer_nearest(s->tracer, probe->position, probe->normal, &hit)) return reading;
    const uint32_t *corner = s->scene.view->triangle[hit.triangle];
    rsv_vec3 a = s->scene.view->position[corner[0]];
    rsv_vec3 front = v3_cross(v3_sub(s->scene.view->position[corner[1]], a),
        v3_sub(s->scene.view->position[corner[2]], a));
    reading.irradiance = rsv_light_view_irradiance(
        s, hit.triangle, hit.u, hit.v, v3_dot(front, probe->normal) < 0, RSV_NONE);
    uint32_t face = s->elements->face_of[v3_dot(front, probe->normal) < 0][hit.triangle];
    if (face != RSV_NONE)
        add_stored_noise(&reading, rsv_stored_noise_at(noise, face, hit.u, hit.v, false));
    return reading;
}

typedef struct reading_job {
    rsv_probe_job job;
    bool lookup;
    const rsv_probe *probe;
    rsv_probe_reading *reading;
    size_t count;
    atomic_size_t done;
} reading_job;

static void read_probes(void *user, rsv_span span)
{
    reading_job *r = user;
    const rsv_light_view *s = r->job.solution;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(s->context); k++) {
        r->reading[k] = r->lookup ? look_up(s, r->job.noise, &r->probe[k])
                                  : rsv_probe_read(&r->job, &r->probe[k], (uint32_t)k);
        rsv_item_done(s->context, "probe", span.worker, &r->done, r->count);
    }
}

void rsv_probe_desc_init(rsv_probe_desc *desc, size_t size)
{
    const rsv_probe_desc defaults = {
        .size = sizeof defaults, .mode = RSV_PROBE_OPERATOR, .samples = 4096
    };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_probe_irradiance(const rsv_light *light, const rsv_probe_desc *desc,
    const rsv_probe *probes, size_t probe_count, rsv_probe_reading *readings)
{
    const rsv_light_view *solution = rsv_light_get_view(light);
    rsv_context *context = solution->context;
    rsv_probe_desc settings = rsv_default_probe_desc();
    rsv_status status = RSV_READ_DESC(rsv_probe_desc, &settings, desc);
    if (status != RSV_OK) return status;
    bool lookup = settings.mode == RSV_PROBE_LOOKUP;
    if (settings.mode == RSV_PROBE_REFERENCE)
        return rsv_probe_reference(
            solution->scene.scene, probes, probe_count, settings.samples, settings.seed, readings);
    status = rsv_check_probes(probes, probe_count);
    if (status != RSV_OK) return status;
    reading_job work = { .job = rsv_probe_job_of(solution, settings.samples, settings.seed, true),
        .lookup = lookup,
        .probe = probes,
        .reading = readings,
        .count = probe_count };
    rsv_stored_noise noise;
    rsv_connections *connections = NULL;
    if (!lookup) status = rsv_connections_create(&solution->scene, solution->lights, &connections);
    if (status != RSV_OK) return status;
    status = rsv_stored_noise_create(solution, lookup, &noise);
    if (status != RSV_OK) {
        rsv_connections_destroy(connections);
        return status;
    }
    work.job.noise = &noise;
    work.job.connections = connections;
    rsv_parallel_for(context, probe_count, 1, read_probes, &work);
    rsv_stored_noise_destroy(&noise);
    rsv_connections_destroy(connections);
    return rsv_progress(context, "probe", 1);
}
