#include "voxel_direct.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "../elements/voxels.h"
#include "../media/fog_run.h"
#include "../sources/air_light.h"
#include "direct_constants.h"

typedef struct air_job {
    const rsv_direct_job *job;
    rsv_voxel_air air;
    rsv_rgb *own; ///< [voxels] out
    atomic_uint_least64_t rays;
} air_job;

// ---- point and spot lights close by ---------------------------------------------------------------

/// A ray from a light through a voxel's cell.
typedef struct polar_ray {
    rsv_vec3 direction;
    double begin, end; ///< within the cell, metres
} polar_ray;

static polar_ray ray_from(const rsv_voxels *v, uint32_t voxel, rsv_vec3 from, rsv_vec3 direction)
{
    polar_ray ray = { direction, 0, INFINITY };
    rsv_vec3 low = rsv_voxel_low(v, voxel), high = v3_add(low, v->size);
    rsv_fog_clip(from.x, direction.x, low.x, high.x, &ray.begin, &ray.end);
    rsv_fog_clip(from.y, direction.y, low.y, high.y, &ray.begin, &ray.end);
    rsv_fog_clip(from.z, direction.z, low.z, high.z, &ray.begin, &ray.end);
    return ray;
}

/// A place in a voxel's cell: along a ray from the light, where the fluence I / r^2 times the density of places, r^2,
/// has no pole; or anywhere. @param u in [0, 1) @return false if the ray misses the cell
static bool draw_place(
    const rsv_voxels *v, uint32_t voxel, rsv_vec3 from, const float u[3], rsv_vec3 *place)
{
    bool polar = u[2] < 0.5f;
    float along = 2 * u[2] - (polar ? 0 : 1);
    if (!polar) {
        rsv_vec3 share = v3(u[0] * v->size.x, u[1] * v->size.y, along * v->size.z);
        *place = v3_add(rsv_voxel_low(v, voxel), share);
        return true;
    }
    polar_ray ray = ray_from(v, voxel, from, rsv_square_to_sphere(u[0], u[1]));
    if (!(ray.end > ray.begin)) return false;
    double distance = ray.begin + (double)along * (ray.end - ray.begin);
    *place = v3_mad(from, (float)distance, ray.direction);
    return true;
}

/// Density of that per volume, times the squared distance. @param direction unit, from the light
static double place_density(
    const rsv_voxels *v, uint32_t voxel, rsv_vec3 from, rsv_vec3 direction, double square)
{
    polar_ray ray = ray_from(v, voxel, from, direction);
    double volume = (double)v->size.x * (double)v->size.y * (double)v->size.z;
    double polar = ray.end > ray.begin ? 1 / (4 * M_PI * (ray.end - ray.begin)) : 0;
    return 0.5 * polar + 0.5 * square / volume;
}

/// @param from a place on the light @param u in [0, 1)
static rsv_rgb sample_near(const rsv_voxel_air *a, uint32_t voxel, const rsv_punctual_light *light,
    rsv_vec3 from, const float u[3], uint64_t *rays)
{
    rsv_vec3 place;
    rsv_punctual_sample sample = { .light = light };
    if (!draw_place(a->voxels, voxel, from, u, &place) ||
        !rsv_punctual_arriving(a->setting.lights->lights->scene, light, from, place, &sample) ||
        rsv_voxels_find(a->voxels, a->setting.tracer, place) != voxel)
        return rgb_gray(0);
    ++*rays;
    rsv_ray shadow = rsv_punctual_ray(&sample, place);
    rsv_rgb seen = rsv_air_passed(&a->setting, &shadow, place, sample.direction, sample.distance);
    double square = (double)sample.distance * (double)sample.distance;
    double density = place_density(a->voxels, voxel, from, v3_neg(sample.direction), square);
    double scale = square / (density * (double)rsv_voxel_volume(a->voxels, voxel));
    scale *= (double)rsv_voxels_density(a->voxels, place);
    scale /= (double)rsv_voxel_mean_density(a->voxels, voxel);
    return scale < INFINITY ? rgb_scale(rgb_mul(sample.irradiance, seen), (float)scale)
                            : rgb_gray(0);
}

rsv_air_receiver rsv_voxel_receiver(const rsv_voxels *v, uint32_t voxel, rsv_vec3 place)
{
    return (rsv_air_receiver){
        .point = place, .near = rsv_voxel_centre(v, voxel), .radius = v3_length(v->size)
    };
}

rsv_rgb rsv_voxel_near_light(const rsv_voxel_air *a, uint32_t voxel, const rsv_air_receiver *r,
    const float u[4], uint64_t *rays)
{
    const rsv_lights *lights = a->setting.lights->lights;
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = lights->distant_count; k < lights->punctual_count; k++) {
        const rsv_punctual_light *light = &lights->scene->light[lights->punctual[k]];
        if (!rsv_air_leaves_out(r, light)) continue;
        rsv_vec3 from = rsv_punctual_place_by(light, u[3], (uint32_t)k);
        sum = rgb_add(sum, sample_near(a, voxel, light, from, u, rays));
    }
    return sum;
}

static bool is_near_any(const rsv_voxel_air *a, const rsv_air_receiver *r)
{
    const rsv_lights *lights = a->setting.lights->lights;
    for (size_t k = lights->distant_count; k < lights->punctual_count; k++)
        if (rsv_air_leaves_out(r, &lights->scene->light[lights->punctual[k]])) return true;
    return false;
}

static rsv_rgb from_near(
    const air_job *a, uint32_t voxel, const rsv_air_receiver *r, uint64_t *rays)
{
    rsv_rgb sum = rgb_gray(0);
    uint32_t stream = rsv_hash3(a->job->setting.seed, voxel, 0x9e0u);
    if (!is_near_any(&a->air, r)) return sum;
    for (uint32_t n = 0; n < NEAR_LIGHT_SAMPLES; n++) {
        float u[4];
        rsv_sobol_2d(n, stream, &u[0], &u[1]);
        rsv_sobol_2d(n, rsv_hash(stream), &u[2], &u[3]);
        sum = rgb_mad(
            sum, 1.0f / NEAR_LIGHT_SAMPLES, rsv_voxel_near_light(&a->air, voxel, r, u, rays));
    }
    return sum;
}

// ---- all others ---------------------------------------------------------------------------------

static rsv_rgb sample_voxel(
    const air_job *a, uint32_t voxel, uint32_t index, rsv_air_receiver *r, uint64_t *rays)
{
    uint32_t seed = a->job->setting.seed;
    float place[3], u[5];
    rsv_sobol_2d(index, rsv_hash3(seed, voxel, 0x51u), &place[0], &place[1]);
    place[2] = rsv_sobol_1d(index, rsv_hash3(seed, voxel, 0x52u));
    u[0] = rsv_sobol_1d(index, rsv_hash3(seed, voxel, 0x53u));
    rsv_sobol_2d(index, rsv_hash3(seed, voxel, 0x54u), &u[1], &u[2]);
    rsv_sobol_2d(index, rsv_hash3(seed, voxel, 0x55u), &u[3], &u[4]);
    r->point = rsv_voxel_place(a->air.voxels, voxel, place);
    return rsv_air_light(&a->air.setting, r, u, rays);
}

static rsv_rgb estimate(const air_job *a, uint32_t voxel, uint64_t *rays)
{
    rsv_air_receiver r = rsv_voxel_receiver(a->air.voxels, voxel, v3(0, 0, 0));
    uint32_t samples = a->job->samples;
    rsv_rgb sum = from_near(a, voxel, &r, rays);
    for (uint32_t k = 0; k < samples; k++)
        sum = rgb_mad(sum, 1 / (float)samples, sample_voxel(a, voxel, k, &r, rays));
    return rgb_scale(sum, 0.25f);
}

static void light_voxels(void *data, rsv_span span)
{
    air_job *a = data;
    rsv_context *context = a->job->elements->context;
    rsv_team_place place = rsv_team_place_of(context);
    uint64_t traced = 0;
    for (size_t k = span.begin; k < span.end; k++)
        if (rsv_team_owns(place, k, RSV_TEAM_BLOCK) && !rsv_cancelled(context))
            a->own[k] = estimate(a, (uint32_t)k, &traced);
    atomic_fetch_add(&a->rays, traced);
}

static void estimate_all(air_job *a, uint64_t *rays)
{
    rsv_context *context = a->job->elements->context;
    size_t count = a->air.voxels->count;
    rsv_parallel_for(context, count, 64, light_voxels, a);
    *rays += rsv_team_total(context, a->rays);
    rsv_team_merge(context, a->own, sizeof *a->own, count, RSV_TEAM_BLOCK);
}

rsv_status rsv_voxel_direct(const rsv_direct_job *job, rsv_rgb *irradiance, uint64_t *rays)
{
    const rsv_elements *e = job->elements;
    rsv_fog_lights lights;
    rsv_status status = rsv_fog_lights_create(e->context, job->setting.lights, &lights);
    air_job a = { .job = job,
        .air = { e->voxels, { &lights, job->scene->tracer, job->scene->view->fog } },
        .own = irradiance + rsv_elements_surface_nodes(e) };
    if (status == RSV_OK) estimate_all(&a, rays);
    rsv_fog_lights_destroy(&lights);
    return status == RSV_OK ? rsv_progress(e->context, "direct", 1) : status;
}
