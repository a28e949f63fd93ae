#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../core/team.h"
#include "../scene/scene.h"
#include "../trace/backs.h"
#include "../trace/film.h"
#include "reference_internal.h"
#include "resolvent/render.h"

static const char phase[] = "reference";

#define APERTURE 0x3c6ef372u ///< of random numbers

static const char *const order_name[RSV_PATH_ORDERS] = { "emission", "direct", "bounce1", "bounce2",
    "bounce3", "bounce4", "bounce5", "bounce6", "bounce7+" };

/// Running sums, all in double: a picture may take millions of samples per pixel.
typedef struct pixel_sum {
    double order[RSV_PATH_ORDERS][3];
    double total[3];
    double luminance, luminance_squared;
} pixel_sum;

/// Of one row of the picture, or of all.
typedef struct row_statistics {
    double luminance, luminance_squared; ///< sums over samples
    double variance_of_means;            ///< sum over pixels of the variance of their mean
    uint64_t rejected;                   ///< samples that were not finite
} row_statistics;

typedef struct picture_job {
    const rsv_path_tracer *tracer;
    const rsv_camera *camera;
    rsv_film film;
    rsv_medium medium; ///< the camera's
    const rsv_render_desc *desc;
    rsv_image *image;
    row_statistics *row; ///< [height]
} picture_job;

void rsv_render_desc_init(rsv_render_desc *desc, size_t size)
{
    const rsv_render_desc defaults = { .size = sizeof defaults,
        .mode = RSV_RENDER_FINAL,
        .width = 512,
        .height = 512,
        .samples = 16,
        .path_depth = 64,
        .seed = 1 };
    rsv_desc_fill(desc, size, &defaults);
}

static void add_rgb(double sum[3], rsv_rgb value)
{
    sum[0] += (double)value.r;
    sum[1] += (double)value.g;
    sum[2] += (double)value.b;
}

static rsv_rgb mean_rgb(const double sum[3], uint32_t samples)
{
    return rgb((float)(sum[0] / samples), (float)(sum[1] / samples), (float)(sum[2] / samples));
}

/// False if the sample is not finite; it then counts as black.
static bool add_sample(pixel_sum *sum, const rsv_path_light *light)
{
    rsv_rgb total = rsv_path_light_total(light);
    double luminance = (double)rgb_luminance(total);
    if (!isfinite(luminance)) return false;
    add_rgb(sum->total, total);
    for (int i = 0; i < RSV_PATH_ORDERS; i++)
        add_rgb(sum->order[i], light->order[i]);
    sum->luminance += luminance;
    sum->luminance_squared += luminance * luminance;
    return true;
}

static void store_pixel(const picture_job *picture, size_t index, const pixel_sum *sum)
{
    uint32_t samples = picture->desc->samples;
    rsv_image_pixels(picture->image, 0)[index] = mean_rgb(sum->total, samples);
    for (uint32_t layer = 1; layer < rsv_image_layer_count(picture->image); layer++)
        rsv_image_pixels(picture->image, layer)[index] = mean_rgb(sum->order[layer - 1], samples);
}

/// Unbiased variance of one sample from `count` of them.
static double sample_variance(double sum, double sum_squared, double count)
{
    return count > 1 ? fmax(sum_squared - sum * sum / count, 0) / (count - 1) : 0;
}

static void render_pixel(const picture_job *picture, uint32_t x, uint32_t y, row_statistics *row)
{
    const rsv_render_desc *desc = picture->desc;
    uint32_t stream = rsv_hash3(x, y, desc->seed);
    pixel_sum sum = { 0 };
    for (uint32_t i = 0; i < desc->samples; i++) {
        float dx, dy, uv[2] = { 0.5f, 0.5f };
        rsv_ray ray;
        rsv_path_light light = { 0 };
        rsv_sobol_2d(i, stream, &dx, &dy);
        if (picture->film.radius > 0) rsv_sobol_2d(i, rsv_hash2(stream, APERTURE), &uv[0], &uv[1]);
        if (rsv_film_ray(&picture->film, (float)x + dx, (float)y + dy, uv, &ray))
            rsv_trace_camera_path(
                picture->tracer, &ray, &picture->medium, (rsv_path_id){ i, stream }, &light);
        if (!add_sample(&sum, &light)) row->rejected++;
    }
    store_pixel(picture, (size_t)y * desc->width + x, &sum);
    double variance = sample_variance(sum.luminance, sum.luminance_squared, desc->samples);
    row->variance_of_means += variance / desc->samples;
    row->luminance += sum.luminance;
    row->luminance_squared += sum.luminance_squared;
}

/// Rows of this process.
typedef struct row_job {
    const picture_job *picture;
    rsv_team_place place;
    size_t count;
    atomic_size_t done;
} row_job;

static void render_rows(void *user, rsv_span span)
{
    row_job *job = user;
    const picture_job *picture = job->picture;
    rsv_context *context = picture->tracer->context;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(context); k++) {
        uint32_t y = job->place.rank + (uint32_t)k * job->place.size;
        for (uint32_t x = 0; x < picture->desc->width; x++)
            render_pixel(picture, x, y, &picture->row[y]);
        rsv_item_done(context, phase, span.worker, &job->done, job->count);
    }
}

static rsv_status render(const picture_job *picture)
{
    rsv_context *context = picture->tracer->context;
    row_job job = { .picture = picture, .place = rsv_team_place_of(context) };
    job.count = rsv_team_turns(job.place, picture->desc->height);
    rsv_parallel_for(context, job.count, 1, render_rows, &job);
    return rsv_team_meet(context, rsv_progress(context, phase, 1));
}

/// In a team, rows from the processes that took their turn with them.
static rsv_status unite_rows(const picture_job *picture)
{
    rsv_context *context = picture->tracer->context;
    uint32_t width = picture->desc->width, height = picture->desc->height;
    for (uint32_t layer = 0; layer < rsv_image_layer_count(picture->image); layer++)
        rsv_team_merge(
            context, rsv_image_pixels(picture->image, layer), width * sizeof(rsv_rgb), height, 1);
    rsv_team_merge(context, picture->row, sizeof *picture->row, height, 1);
    return rsv_team_meet(context, RSV_OK);
}

/// Standard error of the picture's mean luminance over that mean. One sample per pixel says nothing
/// of its own variance: the variance over the whole picture then stands in, which is never smaller.
static double relative_standard_error(const picture_job *picture, const row_statistics *all)
{
    double pixels = (double)picture->desc->width * picture->desc->height;
    double samples = pixels * picture->desc->samples;
    double variance = all->variance_of_means / (pixels * pixels);
    if (picture->desc->samples == 1)
        variance = sample_variance(all->luminance, all->luminance_squared, samples) / samples;
    return all->luminance > 0 ? sqrt(variance) / (all->luminance / samples) : 0;
}

static row_statistics sum_rows(const picture_job *picture)
{
    row_statistics all = { 0 };
    for (uint32_t y = 0; y < picture->desc->height; y++) {
        all.luminance += picture->row[y].luminance;
        all.luminance_squared += picture->row[y].luminance_squared;
        all.variance_of_means += picture->row[y].variance_of_means;
        all.rejected += picture->row[y].rejected;
    }
    return all;
}

static rsv_status check_desc(const rsv_scene_view *scene, const rsv_render_desc *desc)
{
    if (desc->width == 0 || desc->height == 0 || desc->samples == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "reference: %u x %u pixels with %u samples: all three must be at least 1", desc->width,
            desc->height, desc->samples);
    if (desc->camera >= scene->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "reference: camera %u does not exist; the scene has %zu", desc->camera,
            scene->camera_count);
    return rsv_film_check(
        &desc->film, desc->viewpoint ? desc->viewpoint : &scene->camera[desc->camera]);
}

static rsv_status name_layers(rsv_image *image)
{
    rsv_status status = RSV_OK;
    for (uint32_t layer = 1; layer < rsv_image_layer_count(image); layer++)
        RSV_TRY(rsv_image_set_layer_name(image, layer, order_name[layer - 1]));
cleanup:
    return status;
}

rsv_status rsv_render_reference(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image, double *standard_error)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_path_tracer *tracer = NULL;
    rsv_render_desc settings = rsv_default_render_desc();
    picture_job picture = { .desc = &settings };
    RSV_TRY(RSV_READ_DESC(rsv_render_desc, &settings, desc));
    desc = &settings;
    RSV_TRY(rsv_scene_require_committed(scene));
    RSV_TRY(check_desc(view, desc));
    uint32_t layers = desc->layers ? 1 + RSV_PATH_ORDERS : 1;
    RSV_TRY(rsv_image_create(context, desc->width, desc->height, layers, &picture.image));
    RSV_TRY(name_layers(picture.image));
    RSV_TRY(rsv_path_tracer_create(scene, false, &tracer));
    picture.tracer = tracer;
    picture.camera = desc->viewpoint ? desc->viewpoint : &view->camera[desc->camera];
    picture.film =
        rsv_film_of(tracer->tracer, &desc->film, picture.camera, desc->width, desc->height);
    picture.medium =
        rsv_medium_above(&tracer->media, picture.camera->position, picture.camera->forward);
    rsv_warn_of_view(tracer->tracer, picture.camera);
    picture.row = rsv_alloc(context, desc->height, sizeof *picture.row);
    if (!picture.row) RSV_TRY(RSV_ERROR_MEMORY);
    RSV_TRY(render(&picture));
    RSV_TRY(unite_rows(&picture));

    row_statistics all = sum_rows(&picture);
    if (all.rejected)
        rsv_log(context, RSV_LOG_WARNING,
            "reference: %llu samples were not finite and count as black",
            (unsigned long long)all.rejected);
    if (standard_error) *standard_error = relative_standard_error(&picture, &all);
    *image = picture.image;
    picture.image = NULL;
cleanup:
    rsv_free(context, picture.row);
    rsv_path_tracer_destroy(tracer);
    rsv_image_destroy(picture.image);
    return status;
}
