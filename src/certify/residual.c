#include "residual.h"

#include "../core/stratified.h"
#include "../elements/voxels.h"
#include "../receiver/next_event.h"
#include "../render/fog_light.h"
#include "../render/pixel_direct.h"
#include "../sources/partition.h"

/// The surface point at which light is gathered. Must not be copied.
typedef struct receiver {
    const rsv_residual_job *job;
    rsv_receiver at;
    rsv_entrance entrance; ///< how light enters there
    rsv_bsdf storage;
    rsv_medium medium;
    rsv_residual *result;
} receiver;

rsv_residual_job rsv_residual_job_of(
    const rsv_light_view *s, uint32_t gather_rays, uint32_t light_samples)
{
    return (rsv_residual_job){ .solution = s,
        .gather_rays = gather_rays,
        .light_samples = light_samples,
        .stored_caustics = rsv_has_unseen_caustics(s),
        .exact_direct = !s->desc.direct_level };
}

static void set_up_receiver(const rsv_residual_job *job, const rsv_face_point *p, receiver *r)
{
    const rsv_light_view *s = job->solution;
    uint32_t triangle = s->elements->face_triangle[p->face];
    r->job = job;
    r->at = rsv_receiver_at(s->scene.view, s->tracer, triangle, p->u, p->v,
        rsv_surface_point_seen(s->scene.view, triangle, p->u, p->v, s->elements->face_back[p->face],
            rsv_point_width(s, p)));
    r->medium = rsv_medium_above(&s->scene.media, r->at.origin, r->at.point.geometric);
    r->entrance = rsv_entrance_through(&r->medium, s->bsdf, RSV_COVER_COAT);
    r->entrance.coat = rsv_surface_bsdf(s->scene.view, s->bsdf,
        (rsv_footprint){ triangle, p->u, p->v, 0, RSV_CHANNEL_ALL }, &r->storage);
}

/// A source that was drawn, and how much of its light arrives.
static float try_light(
    const receiver *r, const rsv_local_lights *local, rsv_random *random, rsv_next_event *event)
{
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(random);
    rsv_next_event_draw(&r->at, &r->entrance, local, u, event);
    r->result->rays += rsv_next_event_asks(event);
    return rsv_next_event_passed(r->job->solution->tracer, event);
}

/// With S_i, V_i, C_i the light, visibility and control of sample i, A the mean of C and a_i the mean visibility of
/// the other samples: mean of S_i V_i + a_i (A - C_i). Samples are independent, so the second term is 0 on
/// average; where all of them see the light, it takes away all noise.
static rsv_rgb from_emitters(const receiver *r, rsv_random *random)
{
    const rsv_lights *lights = r->job->solution->lights;
    rsv_rgb sum = rgb_gray(0), rest = rgb_gray(0), open_rest = rgb_gray(0);
    float open = 0, count = (float)r->job->light_samples;
    if (!rsv_lights_any_sampled(lights)) return sum;
    rsv_local_lights local;
    rsv_receiver_weigh(&r->at, lights, &local);
    if (rsv_local_lights_are_dark(&local)) return sum;
    for (uint32_t k = 0; k < r->job->light_samples; k++) {
        rsv_next_event event;
        float passed = try_light(r, &local, random, &event);
        rsv_rgb difference = rgb_sub(local.unshadowed, event.open);
        rest = rgb_add(rest, difference);
        if (!(passed > 0)) continue;
        sum = rgb_mad(sum, passed, event.light);
        open_rest = rgb_mad(open_rest, passed, difference);
        open += passed;
    }
    if (!r->entrance.coat->coated)
        sum = rgb_mad(sum, 1 / (count - 1), rgb_sub(rgb_scale(rest, open), open_rest));
    return rgb_scale(sum, 1 / count);
}

/// Light found by next-event estimation.
static rsv_rgb sampled_direct(const receiver *r, uint32_t stream)
{
    rsv_random random = rsv_random_from(stream, 1, 0x51f2u);
    rsv_rgb sum = from_emitters(r, &random), punctual = rgb_gray(0);
    const rsv_lights *lights = r->job->solution->lights;
    uint32_t count = lights->punctual_tree || lights->extended ? r->job->light_samples : 1;
    for (uint32_t k = 0; k < count; k++)
        punctual = rgb_add(
            punctual, rsv_punctual_irradiance_at(&r->at, &r->entrance, lights,
                          r->job->solution->tracer, rsv_random_float(&random), &r->result->rays));
    return rgb_mad(sum, 1 / (float)count, punctual);
}

static bool counts(const void *user, uint32_t triangle, uint32_t turns)
{
    const rsv_residual_job *job = user;
    return rsv_gathering_counts(job->solution->lights, triangle, turns, job->stored_caustics);
}

static rsv_rgb radiance_beyond(const rsv_residual_job *job, rsv_vec3 direction, uint32_t turns)
{
    return rsv_gathering_sky(job->solution->lights, direction, turns, job->stored_caustics);
}

/// E~ at the end of a gather ray; diffused below the surface where that is translucent.
static rsv_rgb stored_at(
    const receiver *r, uint32_t face, const rsv_specular_path *end, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    if (rsv_is_translucent(s, face))
        return rgb_add(rsv_light_view_diffused(s, face, end->u, end->v, 0),
            rsv_light_view_diffused(s, face, end->u, end->v, RSV_NONE));
    if (!r->job->exact_direct)
        return rsv_light_view_irradiance(s, end->triangle, end->u, end->v, end->back, RSV_NONE);
    r->result->rays++;
    rsv_rgb direct = rgb_add(rsv_light_view_direct(s, face, end->u, end->v, true),
        rsv_sampled_irradiance(s, end, random));
    return rgb_add(
        direct, rsv_elements_interpolate(s->elements, s->indirect, face, end->u, end->v));
}

static rsv_rgb radiance_at_end(const receiver *r, const rsv_specular_path *end, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    uint32_t face = s->elements->face_of[end->back][end->triangle];
    if (face == RSV_NONE) return rgb_gray(0);
    rsv_bsdf storage;
    rsv_rgb albedo = rsv_specular_bsdf(&s->scene, end, &storage)->base_color;
    rsv_rgb exitance = rgb_mul(albedo, stored_at(r, face, end, random));
    return rgb_scale(rgb_mul(end->weight, exitance), 1 / RSV_PI);
}

/// E~ where a gather ray ends in the fog.
static rsv_rgb radiance_in_fog(const receiver *r, rsv_vec3 place, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    if (r->job->exact_direct) return rsv_fog_radiance_at(s, place, random);
    return rsv_fog_stored_radiance(s, place, false);
}

/// @param entered weight of light along the ray
static rsv_gather follow(const receiver *r, const rsv_ray *ray, rsv_rgb entered, rsv_random *random)
{
    const rsv_transport_scene *scene = &r->job->solution->scene;
    const rsv_emission_wanted wanted = { counts, r->job };
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, ray, &hit)) {
        rsv_gather beyond = rsv_specular_gather_beyond(scene, &r->medium, ray, random, &wanted);
        beyond.emission = rgb_mul(beyond.emission, entered);
        beyond.path.weight = rgb_mul(beyond.path.weight, entered);
        return beyond;
    }
    rsv_specular_path first = rsv_specular_begin(scene, &r->medium, ray->direction, hit);
    rsv_specular_set_spread(&first, 0, hit.t);
    first.weight = rgb_mul(first.weight, entered);
    return rsv_specular_gather(scene, first, random, counts, r->job);
}

/// Radiance that a gather ray has found.
static rsv_rgb radiance_of(const receiver *r, const rsv_gather *gather, rsv_random *random)
{
    const rsv_specular_path *end = &gather->path;
    if (gather->end == RSV_SPECULAR_ESCAPED)
        return rgb_add(gather->emission,
            rgb_mul(end->weight, radiance_beyond(r->job, end->direction, end->turns)));
    if (gather->end == RSV_SPECULAR_SCATTERED)
        return rgb_add(
            gather->emission, rgb_mul(end->weight, radiance_in_fog(r, gather->place, random)));
    if (gather->end != RSV_SPECULAR_DIFFUSE) return gather->emission;
    return rgb_add(gather->emission, radiance_at_end(r, end, random));
}

static rsv_rgb gather_one(
    const receiver *r, rsv_vec3 direction, rsv_rgb entered, rsv_random *random)
{
    rsv_ray ray = { rsv_receiver_start(&r->at, direction), direction, INFINITY };
    rsv_gather gather = follow(r, &ray, entered, random);
    r->result->rays += 1 + gather.path.rays;
    return radiance_of(r, &gather, random);
}

/// Gather rays only rarely find small lamps through glass, so bright caustics get more rays. The stored caustic
/// decides, not the rays' results, so there is no bias.
static uint32_t ray_count(const receiver *r, rsv_rgb stored_caustic)
{
    float mean = (float)r->job->solution->report.mean_irradiance;
    float share = mean > 0 ? f_min(rgb_luminance(stored_caustic) / mean, 1) : 0;
    return r->job->gather_rays * (r->job->stored_caustics ? 1 : 1 + (uint32_t)(15 * share));
}

static rsv_rgb gather(const receiver *r, uint32_t count, uint32_t stream)
{
    double sum[3] = { 0 }; // residuals are small differences of these sums
    for (uint32_t k = 0; k < count; k++) {
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        rsv_random random = rsv_random_from(stream, k, 0x2f6u);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_vec3 direction = v3_turned_to(r->at.point.normal, d);
        // directions below the surface, due to a tilted normal, count, but find nothing
        if (v3_dot(direction, r->at.point.horizon) <= 0) continue;
        rsv_rgb found = gather_one(r, direction, rsv_bsdf_entry(r->entrance.coat, d.z), &random);
        sum[0] += (double)found.r, sum[1] += (double)found.g, sum[2] += (double)found.b;
    }
    double scale = (double)RSV_PI / count;
    return rgb((float)(scale * sum[0]), (float)(scale * sum[1]), (float)(scale * sum[2]));
}

rsv_residual rsv_residual_at(const rsv_residual_job *job, const rsv_face_point *p, uint32_t stream)
{
    const rsv_light_view *s = job->solution;
    rsv_residual result = { 0 };
    receiver r = { .result = &result };
    set_up_receiver(job, p, &r);
    result.ior = rsv_medium_ior(&r.medium, s->bsdf);
    rsv_rgb unsampled = rsv_light_view_direct(s, p->face, p->u, p->v, true);
    rsv_rgb all = rsv_light_view_direct(s, p->face, p->u, p->v, job->exact_direct);
    rsv_rgb stored_direct = rgb_sub(all, unsampled);
    rsv_rgb stored =
        rgb_add(all, rsv_elements_interpolate(s->elements, s->indirect, p->face, p->u, p->v));
    rsv_rgb caustic = rgb_gray(0);
    if (s->caustics.caustic)
        caustic = rsv_elements_interpolate(
            s->caustics.elements, s->caustics.caustic, p->face, p->u, p->v);
    uint32_t rays = ray_count(&r, caustic);
    if (!job->stored_caustics) caustic = rgb_gray(0);
    rsv_rgb missing[2] = { { 0 } };
    if (job->judge) rsv_caustic_judge_at(job->judge, p, missing);
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t own = rsv_hash3(stream, half, 0xc3a5u);
        rsv_rgb direct = sampled_direct(&r, own);
        rsv_rgb found = rgb_add(rgb_add(caustic, missing[half]), gather(&r, rays, own));
        if (!job->exact_direct) {
            found = rgb_add(found, direct);
            result.direct[half] = rgb_sub(direct, stored_direct);
        }
        result.residual[half] = rgb_sub(found, stored);
        result.irradiance[half] = job->exact_direct ? rgb_add(stored, direct) : stored;
    }
    return result;
}

// ---- in fog ---------------------------------------------------------------------------------------

/// A quarter of the fluence that arrives at a place other than straight from sampled sources.
static rsv_rgb gather_in_air(const receiver *r, rsv_vec3 place, uint32_t stream)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < r->job->gather_rays; k++) {
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        rsv_random random = rsv_random_from(stream, k, 0x2f6u);
        rsv_ray ray = { place, rsv_square_to_sphere(x, y), INFINITY };
        rsv_gather gather = follow(r, &ray, rgb_gray(1), &random);
        r->result->rays += 1 + gather.path.rays;
        sum = rgb_add(sum, radiance_of(r, &gather, &random));
    }
    return rgb_scale(sum, RSV_PI / (float)r->job->gather_rays);
}

/// The same straight from those.
static rsv_rgb direct_in_air(const receiver *r, rsv_vec3 place, uint32_t stream)
{
    rsv_rgb sum = rgb_gray(0);
    rsv_random random = rsv_random_from(stream, 1, 0x51f2u);
    for (uint32_t k = 0; k < r->job->light_samples; k++)
        sum = rgb_add(sum, rsv_fog_fluence_sample(r->job->solution, place, &random));
    return rgb_scale(sum, 0.25f / (float)r->job->light_samples);
}

rsv_residual rsv_residual_in_air(const rsv_residual_job *job, uint32_t voxel, uint32_t stream)
{
    const rsv_light_view *s = job->solution;
    const rsv_elements *e = s->elements;
    rsv_residual result = { 0 };
    const receiver r = { .job = job, .result = &result };
    size_t node = rsv_elements_surface_nodes(e) + voxel;
    rsv_random random = rsv_random_from(stream, 0, 0xa12u);
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(&random);
    rsv_vec3 place = rsv_voxel_place(e->voxels, voxel, u);
    rsv_rgb stored = rgb_add(s->source[node], s->indirect[node]), caustic = rgb_gray(0);
    if (job->stored_caustics && s->caustics.coarse_caustic)
        caustic = s->caustics.coarse_caustic[node];
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t half_stream = rsv_hash3(stream, half, 0xc3a5u);
        rsv_rgb found =
            rgb_add(gather_in_air(&r, place, half_stream), direct_in_air(&r, place, half_stream));
        found = rgb_add(found, caustic);
        result.residual[half] = rgb_sub(found, stored);
        result.irradiance[half] = stored;
    }
    return result;
}

static rsv_status check_range(const char *name, uint32_t value, uint32_t least, uint32_t most)
{
    if (value >= least && value <= most) return RSV_OK;
    return rsv_fail(
        RSV_ERROR_ARGUMENT, "certify: %s is %u; it must be %u to %u", name, value, least, most);
}

rsv_status rsv_check_certify_desc(const rsv_certify_desc *desc)
{
    rsv_status status = check_range("samples", desc->samples, 16, 1u << 24);
    if (status == RSV_OK) status = check_range("gather_rays", desc->gather_rays, 1, 1u << 16);
    if (status == RSV_OK) status = check_range("light_samples", desc->light_samples, 2, 1u << 16);
    return status;
}
