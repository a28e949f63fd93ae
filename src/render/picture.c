/// Modes operator and final: camera paths, then the solved light.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../core/team.h"
#include "../trace/backs.h"
#include "outlines.h"
#include "picture_filter.h"
#include "picture_row.h"
#include "picture_series.h"
#include "shot_light.h"

#include <stdio.h>

struct rsv_picture_series {
    rsv_picture_job job; ///< without what differs from picture to picture
    rsv_sky_visibility *visibility;
    rsv_shot_light *shot; ///< NULL = there is none
};

/// In a team, rows of pixels from the processes that took their turn with them.
static rsv_status unite_rows(const rsv_picture_job *job)
{
    rsv_context *context = job->solution->context;
    size_t width = job->desc->width, height = job->desc->height;
    for (uint32_t layer = 0; layer < rsv_image_layer_count(job->image); layer++)
        rsv_team_merge(
            context, rsv_image_pixels(job->image, layer), width * sizeof(rsv_rgb), height, 1);
    if (job->noise) rsv_team_merge(context, job->noise, width * sizeof *job->noise, height, 1);
    return rsv_team_meet(context, RSV_OK);
}

/// Rows of pixels of this process, which workers share.
typedef struct row_work {
    const rsv_picture_job *job;
    rsv_team_place place;
    rsv_share rows;
    atomic_size_t done;
    _Atomic rsv_status result;
} row_work;

static rsv_status render_row(row_work *work, rsv_picture_row *state, size_t index, int worker)
{
    const rsv_picture_job *job = work->job;
    rsv_context *context = job->solution->context;
    uint32_t row = work->place.rank + (uint32_t)index * work->place.size;
    rsv_status status = rsv_picture_row_render(state, row);
    rsv_item_done(context, "render", worker, &work->done, work->rows.count);
    return status;
}

static void render_share(void *user, int worker)
{
    row_work *work = user;
    rsv_picture_row state;
    rsv_status status = rsv_picture_row_create(work->job, &state);
    rsv_span row;
    while (status == RSV_OK && !rsv_cancelled(work->job->solution->context) &&
           rsv_share_take(&work->rows, worker, &row))
        status = render_row(work, &state, row.begin, worker);
    rsv_picture_row_destroy(&state);
    rsv_keep_failure(&work->result, status);
}

static rsv_status render_rows(const rsv_picture_job *job)
{
    rsv_context *context = job->solution->context;
    row_work work = { .job = job, .place = rsv_team_place_of(context) };
    work.rows = rsv_share_of(rsv_team_turns(work.place, job->desc->height), 1);
    rsv_parallel_workers(context, work.rows.count, render_share, &work);
    rsv_status result = work.result;
    if (result == RSV_ERROR_MEMORY) result = rsv_fail(result, "out of memory rendering");
    if (result == RSV_OK) result = rsv_progress(context, "render", 1);
    result = rsv_team_meet(context, result);
    return result == RSV_OK ? unite_rows(job) : result;
}

/// Plans the second pass: of a part, so that all of them together reach the target.
static void plan_second_pass(rsv_picture_job *job, uint32_t *extra)
{
    const rsv_render_desc *desc = job->desc;
    uint32_t samples = desc->samples / job->parts; // the parts divide them
    float wanted = desc->noise * sqrtf((float)job->parts);
    rsv_plan_samples(job->image, job->noise, samples, wanted, extra);
    job->count = extra;
    job->before = samples;
    job->seed = rsv_hash2(desc->seed, 0x2be7u + job->part);
    job->parts = 1;
    job->part = 0;
}

/// Renders all pixels equally, and then the noisy ones again.
static rsv_status render_passes(rsv_picture_job *job)
{
    rsv_context *context = job->solution->context;
    const rsv_render_desc *desc = job->desc;
    size_t pixels = (size_t)desc->width * desc->height;
    rsv_status status = RSV_OK;
    uint32_t *extra = NULL;
    job->seed = desc->seed;
    if (desc->noise <= 0 || desc->shared_pattern || job->count) return render_rows(job);
    job->noise = rsv_alloc(context, pixels, sizeof *job->noise);
    extra = rsv_alloc(context, pixels, sizeof *extra);
    if (!job->noise || !extra) status = RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = render_rows(job);
    if (status == RSV_OK) {
        plan_second_pass(job, extra);
        status = render_rows(job);
    }
    rsv_free(context, job->noise);
    rsv_free(context, extra);
    return status;
}

static rsv_status name_guides(rsv_image *image, uint32_t first)
{
    static const char *const names[] = { "diffuse", "albedo", "normal", "place" };
    rsv_status status = RSV_OK;
    for (uint32_t guide = 0; guide < RSV_PICTURE_GUIDES && status == RSV_OK; guide++)
        status = rsv_image_set_layer_name(image, first + guide, names[guide]);
    return status;
}

static rsv_status name_layers(rsv_image *image, uint32_t layer_count)
{
    rsv_status status = RSV_OK;
    for (uint32_t layer = 1; layer < layer_count && status == RSV_OK; layer++) {
        char name[32] = "emission";
        if (layer == 2) snprintf(name, sizeof name, "direct");
        if (layer > 2)
            snprintf(
                name, sizeof name, "bounce%u%s", layer - 2, layer == RSV_PICTURE_LAYERS ? "+" : "");
        status = rsv_image_set_layer_name(image, layer, name);
    }
    return status;
}

static rsv_status check_desc(const rsv_light_view *solution, const rsv_render_desc *desc)
{
    if (desc->width == 0 || desc->height == 0 || desc->width > 65536 || desc->height > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: size %ux%u is not in 1x1 .. 65536x65536",
            desc->width, desc->height);
    if (desc->samples == 0 || (uint64_t)desc->samples * desc->width > UINT32_MAX)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "render: %u samples per pixel are not possible", desc->samples);
    if ((uint64_t)desc->samples * desc->gather_rays > 1u << 30)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "render: %u samples of %u gather rays are too many for a pixel: at most 2^30 rays; lower either",
            desc->samples, desc->gather_rays);
    if (!(desc->noise >= 0 && desc->noise <= 1))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "render: a noise of %g is not in 0 .. 1", (double)desc->noise);
    if (desc->camera >= solution->scene.view->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: camera %u does not exist, the scene has %zu",
            desc->camera, solution->scene.view->camera_count);
    if (desc->layers && solution->order_count == 0)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "render: this light keeps no bounces (it followed moved objects, or was changed as a whole), so it has no "
            "layers; solve again for them");
    if (desc->denoise && (desc->layers || desc->shared_pattern))
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: a picture with %s cannot be denoised",
            desc->layers ? "layers" : "a shared pattern");
    if (desc->mode == RSV_RENDER_REFERENCE)
        return rsv_fail(RSV_ERROR_ARGUMENT, "render: use rsv_render_reference for mode reference");
    return rsv_film_check(&desc->film,
        desc->viewpoint ? desc->viewpoint : &solution->scene.view->camera[desc->camera]);
}

static void begin_job(
    const rsv_light_view *solution, const rsv_render_desc *desc, rsv_picture_job *job)
{
    *job = (rsv_picture_job){ .solution = solution,
        .parts = 1,
        .camera = desc->viewpoint ? desc->viewpoint : &solution->scene.view->camera[desc->camera] };
    job->film = rsv_film_of(solution->tracer, &desc->film, job->camera, desc->width, desc->height);
    job->spread = rsv_film_spread(&job->film);
    job->medium =
        rsv_medium_above(&solution->scene.media, job->camera->position, job->camera->forward);
    if (solution->lights->environment) job->sky = solution->lights->environment->whole;
    job->setting = (rsv_camera_setting){ &solution->scene, solution->lights, NULL, desc->path_depth,
        !desc->shared_pattern && rsv_film_is_plain(&desc->film) && rsv_shot_light_wanted(solution),
        solution->scene.view->fog ? rsv_picture_cross_fog : NULL, 0, !desc->shared_pattern, false };
}

rsv_status rsv_picture_series_create(
    const rsv_light *light, const rsv_render_desc *desc, rsv_picture_series **series)
{
    const rsv_light_view *solution = rsv_light_get_view(light);
    rsv_status status = check_desc(solution, desc);
    if (status != RSV_OK) return status;
    rsv_picture_series *s = rsv_alloc(solution->context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    *s = (rsv_picture_series){ 0 };
    rsv_picture_job *job = &s->job;
    begin_job(solution, desc, job);
    rsv_warn_of_view(solution->tracer, job->camera);
    if (!desc->shared_pattern) RSV_TRY(rsv_sky_visibility_create(solution, &s->visibility));
    job->setting.visibility = s->visibility;
    if (job->setting.shot)
        RSV_TRY(rsv_shot_light_create(solution, desc, job->camera, &job->medium, &s->shot));
    *series = s;
    s = NULL;
cleanup:
    rsv_picture_series_destroy(s);
    return status;
}

void rsv_picture_series_destroy(rsv_picture_series *s)
{
    if (!s) return;
    rsv_sky_visibility_destroy(s->visibility);
    rsv_shot_light_destroy(s->shot);
    rsv_free(s->job.solution->context, s);
}

/// Light paths of a part are its own.
static rsv_status shoot(const rsv_shot_light *shot, const rsv_picture_job *job)
{
    rsv_render_desc desc = *job->desc;
    desc.samples /= job->parts;
    if (job->part > 0) desc.seed = rsv_hash2(desc.seed, job->part);
    return rsv_shot_light_add(shot, &desc, job->image);
}

/// @param job with the number of samples and what is gathered
static rsv_status take(const rsv_picture_series *series, const rsv_render_desc *desc,
    rsv_picture_job job, rsv_image **image)
{
    rsv_status status = check_desc(job.solution, desc);
    if (status != RSV_OK) return status;
    job.desc = desc;
    job.layer_count = desc->layers ? 1 + RSV_PICTURE_LAYERS : 1;
    job.guides = desc->denoise;
    uint32_t layers = job.layer_count + (job.guides ? RSV_PICTURE_GUIDES : 0);
    RSV_TRY(rsv_image_create(job.solution->context, desc->width, desc->height, layers, &job.image));
    RSV_TRY(name_layers(job.image, job.layer_count));
    if (job.guides) RSV_TRY(name_guides(job.image, job.layer_count));
    rsv_picture_job passes = job;
    RSV_TRY(render_passes(&passes));
    if (series->shot) RSV_TRY(shoot(series->shot, &job));
    *image = job.image;
    job.image = NULL;
cleanup:
    rsv_image_destroy(job.image);
    return status;
}

rsv_status rsv_picture_series_take(const rsv_picture_series *series, const rsv_render_desc *desc,
    const rsv_picture_pass *pass, rsv_image **image)
{
    rsv_picture_job job = series->job;
    if (pass) {
        job.count = pass->count;
        job.where = pass->where;
        job.gathers_sources = pass->gathered == RSV_GATHERED_ALL && !job.setting.cross_fog;
        job.parts = pass->is_half ? 2 : 1;
        job.part = pass->half;
        job.gather_seed = pass->is_alone ? 1 + pass->half : 0;
    }
    return take(series, desc, job, image);
}

rsv_status rsv_picture_series_find_outlines(
    const rsv_picture_series *series, const rsv_image *picture, uint8_t *is_outline)
{
    return rsv_find_outlines(&series->job, picture, is_outline);
}

bool rsv_picture_series_keeps_caustics(const rsv_picture_series *series)
{
    const rsv_light_view *solution = series->job.solution;
    bool in_fog = series->job.setting.cross_fog && solution->caustics.caustic;
    return in_fog || rsv_has_unseen_caustics(solution);
}

/// Two halves of the same camera rays, and their filtered mean.
static rsv_status take_filtered(
    const rsv_picture_series *series, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_status status = RSV_OK;
    rsv_image *half[2] = { NULL, NULL };
    rsv_render_desc even = *desc;
    even.samples += desc->samples % 2;
    for (uint32_t k = 0; k < 2; k++) {
        const rsv_picture_pass pass = { .is_half = true, .half = k };
        RSV_TRY(rsv_picture_series_take(series, &even, &pass, &half[k]));
    }
    RSV_TRY(rsv_picture_filter(series->job.solution->context, half, image));
cleanup:
    rsv_image_destroy(half[0]);
    rsv_image_destroy(half[1]);
    return status;
}

rsv_status rsv_render(const rsv_light *light, const rsv_render_desc *desc, rsv_image **image)
{
    rsv_picture_series *series = NULL;
    rsv_render_desc settings = rsv_default_render_desc();
    rsv_status status = RSV_READ_DESC(rsv_render_desc, &settings, desc);
    if (status == RSV_OK) status = rsv_picture_series_create(light, &settings, &series);
    if (status == RSV_OK)
        status = settings.denoise ? take_filtered(series, &settings, image)
                                  : rsv_picture_series_take(series, &settings, NULL, image);
    rsv_picture_series_destroy(series);
    return status;
}
