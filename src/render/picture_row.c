#include "picture_row.h"

#include "../trace/packet.h"
#include "camera_path.h"
#include "fog_light.h"
#include "picture_shade.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH
#define APERTURE 0x3c6ef372u ///< of random numbers

/// Camera rays that this pass sends through a pixel.
static uint32_t samples_of(const rsv_picture_row *r, uint32_t column)
{
    const rsv_picture_job *job = r->job;
    return job->count ? job->count[(size_t)r->row * job->desc->width + column] : job->desc->samples;
}

/// Of these camera rays, those of this part.
static uint32_t part_of(const rsv_picture_job *job, uint32_t samples)
{
    return (samples + job->parts - 1 - job->part) / job->parts;
}

static void add_direct_light(void *user, uint32_t column, const rsv_pixel_light *light)
{
    rsv_picture_row *r = user;
    rsv_rgb all = rgb_add(light->of_first, light->of_others);
    r->is_diffuse = true;
    rsv_picture_add_light(r, column, 1, light->of_first);
    r->is_diffuse = false;
    rsv_picture_add_light(r, column, 1, light->of_others);
    rsv_pixel_noise_add_direct(&r->noise[column], rgb_luminance(all), light->squares);
}

/// Adds a camera ray to the batch, which has room for it.
static void aim(rsv_picture_row *r, uint32_t column, uint32_t sample, uint32_t samples)
{
    const rsv_render_desc *desc = r->job->desc;
    rsv_picture_batch *batch = &r->batch;
    float x, y, uv[2] = { 0.5f, 0.5f };
    uint32_t seed = rsv_hash3(r->job->seed, r->row, column);
    if (r->job->film.radius > 0)
        rsv_stratified_2d(sample, samples, rsv_hash2(seed, APERTURE), &uv[0], &uv[1]);
    if (desc->shared_pattern)
        rsv_shared_place(sample, &x, &y);
    else
        rsv_stratified_2d(sample, samples, seed, &x, &y);
    rsv_ray ray;
    bool sees = rsv_film_ray(&r->job->film, (float)column + x, (float)r->row + y, uv, &ray);
    if (!sees) ray.t_max = -1; // not traced
    uint32_t k = batch->count++;
    batch->column[k] = column;
    batch->sample[k] = sample;
    rsv_packet_set_ray(&batch->packet, k, ray);
}

/// The solid angle of one sample, as an angle. Shared patterns get finer with every sample, for any final number.
static float spread_of(const rsv_picture_row *r)
{
    uint32_t samples = r->job->desc->shared_pattern ? r->sample.index + 1 : r->job->desc->samples;
    return r->job->spread / sqrtf((float)samples);
}

static void add_fog_light(void *user, uint32_t order, rsv_rgb radiance)
{
    rsv_picture_row *r = user;
    uint32_t last = RSV_PICTURE_LAYERS - 1;
    rsv_picture_add_light(r, r->column, order < last ? order : last, radiance);
}

static void gather_in_fog(void *user, rsv_vec3 place, rsv_rgb weight, rsv_random *random)
{
    rsv_picture_gather_in_fog(user, place, weight, random);
}

/// Numbers of a segment: stratified over the pixel's samples for the first one.
static void draw_for_fog(const rsv_picture_row *r, bool first, uint32_t trail, float u[8])
{
    rsv_random random = rsv_random_from(trail, r->sample.index, 0xf09u);
    bool stratified = first && !r->job->desc->shared_pattern;
    for (uint32_t k = 0; k < 8; k += 2) {
        u[k] = rsv_random_float(&random);
        u[k + 1] = rsv_random_float(&random);
        if (stratified) rsv_pixel_sample_2d(r->sample, 30 + k, &u[k], &u[k + 1]);
    }
}

/// @param trail names the segment
static rsv_rgb march(
    rsv_picture_row *r, const rsv_ray *ray, rsv_rgb throughput, uint32_t trail, bool first)
{
    const rsv_picture_job *job = r->job;
    bool final = job->desc->mode == RSV_RENDER_FINAL;
    rsv_fog_segment segment = { .ray = *ray,
        .throughput = throughput,
        .seed = rsv_hash2(trail, r->sample.index),
        .final = final,
        .by_order = job->layer_count > 1,
        .gather = rsv_picture_gathers(r) ? gather_in_fog : NULL };
    draw_for_fog(r, first, trail, segment.u);
    return rsv_fog_march(job->solution, &segment, add_fog_light, r);
}

rsv_rgb rsv_picture_cross_fog(
    void *user, const rsv_ray *segment, rsv_rgb throughput, uint32_t trail)
{
    return march(user, segment, throughput, trail, false);
}

/// The fog in front of a camera ray's hit. @param ray up to that @return its transmittance
static rsv_rgb see_fog(rsv_picture_row *r, const rsv_ray *ray)
{
    if (!r->job->setting.cross_fog || r->job->medium.depth) return rgb_gray(1);
    return march(r, ray, rgb_gray(1), r->sample.seed, true);
}

static rsv_ray ray_of_lane(const rsv_ray_packet *p, uint32_t k)
{
    return (rsv_ray){ v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]),
        v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]),
        p->triangle[k] == RSV_NONE ? INFINITY : p->t_max[k] };
}

/// The first surface, for guides.
static void note_surface(rsv_picture_row *r, const rsv_specular_path *path, float distance)
{
    rsv_surface_point point = rsv_surface_point_seen(r->job->solution->scene.view, path->triangle,
        path->u, path->v, path->back, rsv_width_of_sample(path->width, r->sample));
    rsv_rgb *normal = &r->guide[RSV_GUIDE_NORMAL][r->column];
    *normal = rgb_add(*normal, rgb(point.normal.x, point.normal.y, point.normal.z));
    r->guide[RSV_GUIDE_PLACE][r->column].r += 1 / f_max(distance, 1e-20f);
}

/// Shades the ray in lane k of the batch.
static void shade_ray(rsv_picture_row *r, uint32_t k)
{
    const rsv_picture_job *job = r->job;
    const rsv_ray_packet *packet = &r->batch.packet;
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    if (packet->t_max[k] < 0) return; // the film sees nothing there
    rsv_ray ray = ray_of_lane(packet, k);
    rsv_rgb passed = see_fog(r, &ray);
    if (packet->triangle[k] == RSV_NONE) {
        rsv_picture_add_light(
            r, r->column, 0, rgb_mul(passed, rsv_sky_radiance(&job->sky, direction)));
        return;
    }
    rsv_specular_path path = rsv_specular_begin(
        &job->solution->scene, &job->medium, direction, rsv_packet_hit(packet, k));
    rsv_specular_set_spread(&path, spread_of(r), packet->t_max[k]);
    path.weight = rgb_mul(path.weight, passed);
    if (job->guides) note_surface(r, &path, packet->t_max[k]);
    rsv_rgb emission =
        rsv_camera_path(&job->setting, path, rsv_hash2(r->sample.seed, r->sample.index),
            job->desc->shared_pattern ? NULL : &r->sample, rsv_picture_shade, r);
    rsv_picture_add_light(r, r->column, 0, emission);
}

static void trace_batch(rsv_picture_row *r)
{
    rsv_picture_batch *batch = &r->batch;
    for (uint32_t k = batch->count; k < LANES; k++)
        batch->packet.t_max[k] = -1;
    rsv_tracer_closest_packet(r->job->solution->tracer, &batch->packet, true);
    for (uint32_t k = 0; k < batch->count; k++) {
        r->column = batch->column[k];
        r->sample = (rsv_pixel_sample){ batch->sample[k], samples_of(r, r->column),
            rsv_pixel_seed(r->job->seed, r->row, r->column) };
        rsv_rgb before = r->layer[0][r->column];
        shade_ray(r, k);
        rsv_rgb seen = rgb_sub(r->layer[0][r->column], before);
        rsv_pixel_noise_add(&r->noise[r->column], rgb_luminance(seen));
    }
    batch->count = 0;
}

/// Averages the pixels of one layer over their samples; those of a second pass join the first's.
/// @param sum [width] over this pass
static void average(const rsv_picture_row *r, uint32_t layer, const rsv_rgb *sum)
{
    const rsv_picture_job *job = r->job;
    rsv_rgb *out = rsv_image_pixels(job->image, layer) + (size_t)r->row * job->desc->width;
    for (uint32_t column = 0; column < job->desc->width; column++) {
        uint32_t samples = part_of(job, samples_of(r, column)), before = job->before;
        if (samples == 0) continue;
        rsv_rgb both = rgb_mad(sum[column], (float)before, out[column]);
        out[column] = rgb_scale(both, 1 / (float)(before + samples));
        // the control variate of a nearly black pixel can end a hair below zero
        if (layer < job->layer_count) out[column] = rgb_positive(out[column]);
    }
}

static void average_all(const rsv_picture_row *r)
{
    uint32_t count = r->job->layer_count;
    for (uint32_t layer = 0; layer < count; layer++)
        average(r, layer, r->layer[layer]);
    for (uint32_t guide = 0; r->job->guides && guide < RSV_PICTURE_GUIDES; guide++)
        average(r, count + guide, r->guide[guide]);
}

rsv_status rsv_picture_row_render(rsv_picture_row *r, uint32_t index)
{
    const rsv_picture_job *job = r->job;
    uint32_t width = job->desc->width;
    r->row = index;
    for (uint32_t layer = 0; layer < job->layer_count; layer++)
        memset(r->layer[layer], 0, width * sizeof(rsv_rgb));
    for (uint32_t guide = 0; job->guides && guide < RSV_PICTURE_GUIDES; guide++)
        memset(r->guide[guide], 0, width * sizeof(rsv_rgb));
    memset(r->noise, 0, width * sizeof *r->noise);
    for (uint32_t column = 0; column < width; column++) {
        uint32_t samples = samples_of(r, column);
        for (uint32_t sample = job->part; sample < samples; sample += job->parts) {
            aim(r, column, sample, samples);
            if (r->batch.count == LANES) trace_batch(r);
        }
    }
    if (r->batch.count) trace_batch(r);
    rsv_status status = rsv_pixel_direct_resolve(&r->direct, r->noise, add_direct_light, r);
    average_all(r);
    if (job->noise && !job->count)
        memcpy(job->noise + (size_t)index * width, r->noise, width * sizeof *r->noise);
    return status;
}

rsv_status rsv_picture_row_create(const rsv_picture_job *job, rsv_picture_row *r)
{
    memset(r, 0, sizeof *r);
    r->job = job;
    memset(r->batch.packet.mask, 0xff, sizeof r->batch.packet.mask);
    rsv_status status = rsv_pixel_direct_begin(&r->direct, job->solution, job->desc->width);
    if (status != RSV_OK) return status;
    r->noise = rsv_alloc(job->solution->context, job->desc->width, sizeof *r->noise);
    if (!r->noise) return RSV_ERROR_MEMORY;
    for (uint32_t layer = 0; layer < job->layer_count; layer++) {
        r->layer[layer] = rsv_alloc(job->solution->context, job->desc->width, sizeof(rsv_rgb));
        if (!r->layer[layer]) return RSV_ERROR_MEMORY;
    }
    for (uint32_t guide = 0; job->guides && guide < RSV_PICTURE_GUIDES; guide++) {
        r->guide[guide] = rsv_alloc(job->solution->context, job->desc->width, sizeof(rsv_rgb));
        if (!r->guide[guide]) return RSV_ERROR_MEMORY;
    }
    return RSV_OK;
}

void rsv_picture_row_destroy(rsv_picture_row *r)
{
    for (uint32_t layer = 0; layer < r->job->layer_count; layer++)
        rsv_free(r->job->solution->context, r->layer[layer]);
    for (uint32_t guide = 0; guide < RSV_PICTURE_GUIDES; guide++)
        rsv_free(r->job->solution->context, r->guide[guide]);
    rsv_free(r->job->solution->context, r->noise);
    rsv_pixel_direct_end(&r->direct);
}
