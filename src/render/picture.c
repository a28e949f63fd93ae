/// Modes operator and final: camera chains, then the solved light.
#include "../core/team.h"
#include "../solve/solution.h"
#include "../trace/camera_ray.h"
#include "camera_chain.h"
#include "pixel_direct.h"
#include "pixel_noise.h"
#include "resolvent/render.h"
#include "shot_light.h"

#include <stdio.h>
#include <string.h>

#define LANES RSV_PACKET_WIDTH
/// Layers after the picture itself: emission, then one per kept order.
#define MAX_LAYERS (1 + RSV_KEPT_ORDERS)

typedef struct picture_job {
    const rsv_solution *solution;
    const rsv_render_desc *desc;
    const rsv_camera *camera;
    rsv_medium medium; ///< the camera's
    rsv_image *image;
    uint32_t layer_count;   ///< of the image, layer 0 included
    float spread;           ///< of a camera ray: the angle of a pixel
    rsv_sky sky;            ///< what lies beyond the scene
    bool shot;              ///< light over wide lobes is shot from the sources
    uint32_t seed;          ///< of the pass
    rsv_pixel_noise *noise; ///< [height * width] found by the first pass; NULL = nobody asks
    const uint32_t *extra;  ///< [height * width] camera rays of a second pass; NULL in the first
} picture_job;

/// Camera rays of one row, traced together.
typedef struct ray_batch {
    rsv_ray_packet packet;
    uint32_t column[LANES], sample[LANES], count;
} ray_batch;

/// One row of the picture in the making.
typedef struct row_state {
    const picture_job *job;
    rsv_rgb *layer[1 + MAX_LAYERS]; ///< [width] each
    rsv_pixel_noise *noise;         ///< [width] of this row and pass
    rsv_pixel_direct direct;
    ray_batch batch;
    uint32_t row;
    // what rsv_camera_chain's callback needs to know of the ray in hand
    uint32_t column;
    rsv_pixel_sample sample;
} row_state;

/// Camera rays that this pass sends through a pixel.
static uint32_t samples_of(const row_state *r, uint32_t column)
{
    const picture_job *job = r->job;
    return job->extra ? job->extra[(size_t)r->row * job->desc->width + column] : job->desc->samples;
}

/// Adds radiance to the picture and, where wanted, to the layer of its order: 0 = emission, 1 = direct.
static void add_light(row_state *r, uint32_t column, uint32_t order, rsv_rgb radiance)
{
    r->layer[0][column] = rgb_add(r->layer[0][column], radiance);
    if (r->job->layer_count > 1)
        r->layer[1 + order][column] = rgb_add(r->layer[1 + order][column], radiance);
}

static void add_direct_light(void *user, uint32_t column, rsv_rgb radiance, float squares)
{
    row_state *r = user;
    add_light(r, column, 1, radiance);
    rsv_pixel_noise_add_direct(&r->noise[column], rgb_luminance(radiance), squares);
}

static void look_up_indirect(row_state *r, uint32_t face, float u, float v, rsv_rgb weight)
{
    const rsv_solution *s = r->job->solution;
    if (r->job->layer_count == 1) {
        rsv_rgb e = rsv_elements_interpolate(s->elements, s->indirect, face, u, v);
        add_light(r, r->column, 0, rgb_mul(weight, e));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++) {
        rsv_rgb e = rsv_elements_interpolate(s->elements, s->order[order], face, u, v);
        add_light(r, r->column, 1 + order, rgb_mul(weight, e));
    }
}

/// Indirect light of a translucent surface: diffused before it is looked up.
static void look_up_diffused(row_state *r, uint32_t face, float u, float v, rsv_rgb weight)
{
    const rsv_solution *s = r->job->solution;
    if (r->job->layer_count == 1) {
        add_light(r, r->column, 0, rgb_mul(weight, rsv_solution_diffused(s, face, u, v, RSV_NONE)));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++)
        add_light(
            r, r->column, 1 + order, rgb_mul(weight, rsv_solution_diffused(s, face, u, v, order)));
}

/// Direct light of a translucent surface: diffused, and the share of detail that only pixels or the direct level
/// resolve. @param weight radiance at the camera per irradiance
static void shade_translucent(row_state *r, const rsv_chain *chain, uint32_t face, rsv_rgb weight)
{
    const rsv_solution *s = r->job->solution;
    bool final = r->job->desc->mode == RSV_RENDER_FINAL;
    rsv_rgb direct = rsv_solution_diffused(s, face, chain->u, chain->v, 0);
    if (final || s->fine.direct) {
        rsv_unresolved detail = rsv_solution_unresolved(s, face, chain->u, chain->v);
        rsv_rgb stored = rsv_solution_direct(s, face, chain->u, chain->v, final);
        direct = rgb_add(direct, rgb_mul(detail.share, rgb_sub(stored, detail.known)));
        if (final)
            rsv_pixel_direct_add(
                &r->direct, chain, rgb_mul(weight, detail.share), r->column, r->sample);
    }
    add_light(r, r->column, 1, rgb_mul(weight, direct));
    look_up_diffused(r, face, chain->u, chain->v, weight);
}

/// One gather ray's contribution to each order at the receiver.
static void add_gathered(row_state *r, const rsv_gather *gather, rsv_rgb weight, rsv_random *random)
{
    const rsv_solution *s = r->job->solution;
    const rsv_chain *chain = &gather->chain;
    uint32_t face = s->elements->face_of[chain->back][chain->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(&s->scene, chain, &storage);
    weight = rgb_mul(rgb_mul(weight, chain->weight), bsdf->exitance_albedo);
    bool translucent = rsv_is_translucent(s, face);
    rsv_rgb direct = translucent ? rsv_solution_diffused(s, face, chain->u, chain->v, 0)
                                 : rgb_add(rsv_solution_direct(s, face, chain->u, chain->v, true),
                                       rsv_sampled_irradiance(s, chain, random));
    add_light(r, r->column, 2, rgb_mul(weight, direct));
    for (uint32_t order = 1; order < s->order_count; order++) {
        rsv_rgb e = translucent ? rsv_solution_diffused(s, face, chain->u, chain->v, order)
                                : rsv_elements_interpolate(
                                      s->elements, s->order[order], face, chain->u, chain->v);
        uint32_t shown = order + 2 <= RSV_KEPT_ORDERS ? order + 2 : RSV_KEPT_ORDERS;
        add_light(r, r->column, shown, rgb_mul(weight, e));
    }
}

static bool no_emission(const void *user, uint32_t triangle, uint32_t events)
{
    (void)user, (void)triangle, (void)events;
    return false;
}

static void gather_indirect(row_state *r, const rsv_chain *chain, rsv_rgb weight)
{
    const rsv_solution *s = r->job->solution;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(&s->scene, chain, &storage);
    rsv_surface_point point = rsv_surface_point_seen(
        s->scene.view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
    rsv_vec3 origin = rsv_offset_origin(point.position, point.geometric, point.extent), t, b;
    v3_frame(point.normal, &t, &b);
    uint32_t rays = r->job->desc->gather_rays, total = rays * r->sample.count;
    for (uint32_t k = 0; k < rays; k++) {
        float x, y;
        rsv_stratified_2d(r->sample.index * rays + k, total, rsv_hash2(r->sample.seed, 11), &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_ray ray = { origin, v3_mad(v3_mad(v3_scale(t, d.x), d.y, b), d.z, point.normal),
            INFINITY };
        rsv_hit hit;
        if (v3_dot(ray.direction, point.geometric) <= 0 ||
            !rsv_tracer_closest(s->tracer, &ray, &hit))
            continue;
        rsv_random random = rsv_random_from(r->sample.seed, r->sample.index, 97 + k);
        rsv_chain first = rsv_chain_begin(
            &s->scene, &chain->medium, ray.direction, hit.triangle, hit.u, hit.v, hit.t);
        rsv_gather gather = rsv_chain_gather(&s->scene, first, &random, no_emission, NULL);
        rsv_rgb entered = rgb_mul(weight, rsv_bsdf_entry(bsdf, d.z));
        if (gather.end == RSV_CHAIN_DIFFUSE)
            add_gathered(r, &gather, rgb_scale(entered, 1 / (float)rays), &random);
    }
}

/// A diffuse surface seen by the camera.
static void shade(void *user, const rsv_chain *chain, rsv_rgb weight)
{
    row_state *r = user;
    const rsv_solution *s = r->job->solution;
    uint32_t face = s->elements->face_of[chain->back][chain->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(&s->scene, chain, &storage);
    // radiance at the camera per irradiance of the surface
    weight = rgb_scale(rgb_mul(weight, bsdf->exitance_albedo), 1 / RSV_PI);
    if (rsv_is_translucent(s, face)) {
        shade_translucent(r, chain, face, weight);
        return;
    }
    bool final = r->job->desc->mode == RSV_RENDER_FINAL;
    rsv_rgb stored = rsv_solution_direct(s, face, chain->u, chain->v, final);
    add_light(r, r->column, 1, rgb_mul(weight, stored));
    if (final) rsv_pixel_direct_add(&r->direct, chain, weight, r->column, r->sample);
    if (final && r->job->desc->gather_rays)
        gather_indirect(r, chain, weight);
    else
        look_up_indirect(r, face, chain->u, chain->v, weight);
}

/// Adds a camera ray to the batch, which has room for it.
static void aim(row_state *r, uint32_t column, uint32_t sample, uint32_t samples)
{
    const rsv_render_desc *desc = r->job->desc;
    ray_batch *batch = &r->batch;
    float x, y;
    if (desc->shared_pattern)
        rsv_shared_place(sample, &x, &y);
    else
        rsv_stratified_2d(sample, samples, rsv_hash3(r->job->seed, r->row, column), &x, &y);
    rsv_ray ray = rsv_camera_ray(
        r->job->camera, desc->width, desc->height, (float)column + x, (float)r->row + y);
    uint32_t k = batch->count++;
    batch->column[k] = column;
    batch->sample[k] = sample;
    batch->packet.origin_x[k] = ray.origin.x;
    batch->packet.origin_y[k] = ray.origin.y;
    batch->packet.origin_z[k] = ray.origin.z;
    batch->packet.direction_x[k] = ray.direction.x;
    batch->packet.direction_y[k] = ray.direction.y;
    batch->packet.direction_z[k] = ray.direction.z;
    batch->packet.t_max[k] = INFINITY;
}

/// The angle that a sample has for itself. Shared patterns refine with every sample, whatever their number will be.
static float spread_of(const row_state *r)
{
    uint32_t samples = r->job->desc->shared_pattern ? r->sample.index + 1 : r->job->desc->samples;
    return r->job->spread / sqrtf((float)samples);
}

/// What the ray in lane k of the batch sees.
static void shade_ray(row_state *r, uint32_t k)
{
    const picture_job *job = r->job;
    const rsv_ray_packet *packet = &r->batch.packet;
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    if (packet->triangle[k] == RSV_NONE) {
        add_light(r, r->column, 0, rsv_sky_radiance(&job->sky, direction));
        return;
    }
    rsv_chain chain = rsv_chain_begin(&job->solution->scene, &job->medium, direction,
        packet->triangle[k], packet->u[k], packet->v[k], packet->t_max[k]);
    rsv_chain_set_spread(&chain, spread_of(r), packet->t_max[k]);
    rsv_rgb emission = rsv_camera_chain(&job->solution->scene, job->solution->lights, chain,
        rsv_hash2(r->sample.seed, r->sample.index), job->desc->shared_pattern ? NULL : &r->sample,
        job->desc->chain_depth, job->shot, shade, r);
    add_light(r, r->column, 0, emission);
}

static void trace_batch(row_state *r)
{
    ray_batch *batch = &r->batch;
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

/// Averages a pixel of one layer over its samples; those of a second pass join the first's.
static void average(const row_state *r, uint32_t layer, uint32_t column)
{
    const picture_job *job = r->job;
    rsv_rgb *out = rsv_image_pixels(job->image, layer) + (size_t)r->row * job->desc->width + column;
    uint32_t samples = samples_of(r, column), before = job->extra ? job->desc->samples : 0;
    if (samples == 0) return;
    rsv_rgb sum = rgb_mad(r->layer[layer][column], (float)before, *out);
    rsv_rgb mean = rgb_scale(sum, 1 / (float)(before + samples));
    // the control variate of a nearly black pixel can end a hair below zero
    *out = rgb(f_max(mean.r, 0), f_max(mean.g, 0), f_max(mean.b, 0));
}

static rsv_status render_row(row_state *r, uint32_t row)
{
    const picture_job *job = r->job;
    uint32_t width = job->desc->width;
    r->row = row;
    for (uint32_t layer = 0; layer < job->layer_count; layer++)
        memset(r->layer[layer], 0, width * sizeof(rsv_rgb));
    memset(r->noise, 0, width * sizeof *r->noise);
    for (uint32_t column = 0; column < width; column++) {
        uint32_t samples = samples_of(r, column);
        for (uint32_t sample = 0; sample < samples; sample++) {
            aim(r, column, sample, samples);
            if (r->batch.count == LANES) trace_batch(r);
        }
    }
    if (r->batch.count) trace_batch(r);
    rsv_status status = rsv_pixel_direct_resolve(&r->direct, r->noise, add_direct_light, r);
    for (uint32_t layer = 0; layer < job->layer_count; layer++)
        for (uint32_t column = 0; column < width; column++)
            average(r, layer, column);
    if (job->noise && !job->extra)
        memcpy(job->noise + (size_t)row * width, r->noise, width * sizeof *r->noise);
    return status;
}

static rsv_status create_row(const picture_job *job, row_state *r)
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
    return RSV_OK;
}

static void destroy_row(row_state *r)
{
    for (uint32_t layer = 0; layer < r->job->layer_count; layer++)
        rsv_free(r->job->solution->context, r->layer[layer]);
    rsv_free(r->job->solution->context, r->noise);
    rsv_pixel_direct_end(&r->direct);
}

/// In a team, rows of pixels from the processes that took their turn with them.
static rsv_status unite_rows(const picture_job *job)
{
    rsv_context *context = job->solution->context;
    size_t width = job->desc->width, height = job->desc->height;
    for (uint32_t layer = 0; layer < job->layer_count; layer++)
        rsv_team_merge(
            context, rsv_image_pixels(job->image, layer), width * sizeof(rsv_rgb), height, 1);
    if (job->noise) rsv_team_merge(context, job->noise, width * sizeof *job->noise, height, 1);
    return rsv_team_meet(context, RSV_OK);
}

static rsv_status render_rows(const picture_job *job)
{
    rsv_context *context = job->solution->context;
    rsv_status result = RSV_OK;
    rsv_team_place place = rsv_team_place_of(context);
    uint32_t done = 0;
#pragma omp parallel num_threads(rsv_threads(context))
    {
        row_state state;
        rsv_status status = create_row(job, &state);
#pragma omp for schedule(dynamic, 1)
        for (uint32_t row = place.rank; row < job->desc->height; row += place.size) {
            if (status == RSV_OK && !rsv_cancelled(context)) status = render_row(&state, row);
            uint32_t finished;
#pragma omp atomic capture
            finished = ++done;
            if (rsv_thread_index() == 0)
                rsv_progress(
                    context, "render", fmin((double)finished * place.size / job->desc->height, 1));
        }
        destroy_row(&state);
        if (status != RSV_OK) {
#pragma omp critical
            result = status;
        }
    }
    if (result == RSV_ERROR_MEMORY) result = rsv_fail(result, "out of memory rendering");
    if (result == RSV_OK) result = rsv_progress(context, "render", 1);
    result = rsv_team_meet(context, result);
    return result == RSV_OK ? unite_rows(job) : result;
}

/// All pixels alike, then those that are noisier than wanted again.
static rsv_status render_passes(picture_job *job)
{
    rsv_context *context = job->solution->context;
    const rsv_render_desc *desc = job->desc;
    size_t pixels = (size_t)desc->width * desc->height;
    rsv_status status = RSV_OK;
    uint32_t *extra = NULL;
    job->seed = desc->seed;
    if (desc->noise <= 0 || desc->shared_pattern) return render_rows(job);
    job->noise = rsv_alloc(context, pixels, sizeof *job->noise);
    extra = rsv_alloc(context, pixels, sizeof *extra);
    if (!job->noise || !extra) status = RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = render_rows(job);
    if (status == RSV_OK) {
        rsv_plan_samples(job->image, job->noise, desc->samples, desc->noise, extra);
        job->extra = extra;
        job->seed = rsv_hash2(desc->seed, 0x2be7u);
        status = render_rows(job);
    }
    rsv_free(context, job->noise);
    rsv_free(context, extra);
    return status;
}

static rsv_status name_layers(rsv_image *image, uint32_t layer_count)
{
    rsv_status status = RSV_OK;
    for (uint32_t layer = 1; layer < layer_count && status == RSV_OK; layer++) {
        char name[32] = "emission";
        if (layer == 2) snprintf(name, sizeof name, "direct");
        if (layer > 2)
            snprintf(name, sizeof name, "bounce%u%s", layer - 2, layer == MAX_LAYERS ? "+" : "");
        status = rsv_image_set_layer_name(image, layer, name);
    }
    return status;
}

static rsv_status check_desc(const rsv_solution *solution, const rsv_render_desc *desc)
{
    if (desc->width == 0 || desc->height == 0 || desc->width > 65536 || desc->height > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: size %ux%u is not in 1x1 .. 65536x65536",
            desc->width, desc->height);
    if (desc->samples == 0 || (uint64_t)desc->samples * desc->width > UINT32_MAX)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "render: %u samples per pixel are not possible", desc->samples);
    if ((uint64_t)desc->samples * desc->gather_rays > 1u << 30)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "render: %u samples of %u gather rays are too many for a pixel", desc->samples,
            desc->gather_rays);
    if (!(desc->noise >= 0 && desc->noise <= 1))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "render: a noise of %g is not in 0 .. 1", (double)desc->noise);
    if (desc->camera >= solution->scene.view->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: camera %u does not exist, the scene has %zu",
            desc->camera, solution->scene.view->camera_count);
    if (desc->mode == RSV_RENDER_REFERENCE)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: use rsv_render_reference for mode reference");
    return RSV_OK;
}

rsv_status rsv_render(const rsv_solution *solution, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_status status = check_desc(solution, desc);
    if (status != RSV_OK) return status;
    picture_job job = { .solution = solution,
        .desc = desc,
        .camera = desc->viewpoint ? desc->viewpoint : &solution->scene.view->camera[desc->camera],
        .layer_count = desc->layers ? 1 + MAX_LAYERS : 1 };
    job.spread = rsv_camera_spread(job.camera, desc->height);
    job.medium =
        rsv_medium_above(&solution->scene.media, job.camera->position, job.camera->forward);
    if (solution->lights->environment) job.sky = solution->lights->environment->whole;
    RSV_TRY(rsv_image_create(
        solution->context, desc->width, desc->height, job.layer_count, &job.image));
    job.shot = !desc->shared_pattern && rsv_shot_light_wanted(solution);
    RSV_TRY(name_layers(job.image, job.layer_count));
    RSV_TRY(render_passes(&job));
    if (job.shot) RSV_TRY(rsv_add_shot_light(solution, desc, job.camera, &job.medium, job.image));
    *image = job.image;
    return RSV_OK;
cleanup:
    rsv_image_destroy(job.image);
    return status;
}
