#include "judged_frames.h"

#include "camera_flight.h"
#include "stats.h"

#include "resolvent/frame.h"
#include "resolvent/render.h"

#include <cJSON.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { moving_frames = 10, resting_frames = 64, flicker_frames = 16, strip_columns = 6 };

/// Frames between the cut and the previous view.
enum { cut = 60 };

typedef struct judge {
    const cli_bench_task *bench;
    const rsv_light *light;
    const char *name;
    rsv_context *context;
    uint32_t width, height;
    rsv_camera camera; ///< of the frame that is judged
    rsv_frame_renderer *renderer;
    rsv_image *shown;        ///< the last frame
    rsv_image *reference[2]; ///< of that camera
    rsv_image *strip;        ///< NULL = none
} judge;

// ---- pictures -----------------------------------------------------------------------------------

/// Means of 2x2 pixels.
static rsv_status shrink(rsv_context *context, const rsv_image *image, rsv_image **half)
{
    uint32_t width = rsv_image_width(image) / 2, height = rsv_image_height(image) / 2;
    size_t across = rsv_image_width(image);
    rsv_status status = rsv_image_create(context, width, height, 1, half);
    if (status != RSV_OK) return status;
    const rsv_rgb *in = rsv_image_const_pixels(image, 0);
    rsv_rgb *out = rsv_image_pixels(*half, 0);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const rsv_rgb *a = in + 2 * y * across + 2 * x, *b = a + across;
            *out++ = (rsv_rgb){ 0.25f * (a[0].r + a[1].r + b[0].r + b[1].r),
                0.25f * (a[0].g + a[1].g + b[0].g + b[1].g),
                0.25f * (a[0].b + a[1].b + b[0].b + b[1].b) };
        }
    return RSV_OK;
}

/// Copies a picture into a column of the strip.
static void paste(const judge *j, uint32_t column, const rsv_image *image)
{
    if (!j->strip) return;
    rsv_rgb *out = rsv_image_pixels(j->strip, 0);
    const rsv_rgb *in = rsv_image_const_pixels(image, 0);
    size_t across = rsv_image_width(j->strip);
    for (uint32_t y = 0; y < j->height; y++)
        for (uint32_t x = 0; x < j->width; x++)
            out[y * across + column * j->width + x] = in[(size_t)y * j->width + x];
}

static rsv_status show(judge *j, const rsv_camera *camera)
{
    rsv_frame_view view = { .camera = { *camera } };
    rsv_status status = rsv_frame_render(j->renderer, &view, NULL);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status == RSV_OK) rsv_frame_radiance(j->renderer, 0, rsv_image_pixels(j->shown, 0));
    return status;
}

// ---- references ---------------------------------------------------------------------------------

static rsv_status render_reference(judge *j, uint32_t index)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_FINAL;
    desc.width = j->width;
    desc.height = j->height;
    desc.samples = j->bench->reference_samples;
    desc.viewpoint = &j->camera;
    desc.seed = 1000 + index;
    return rsv_render(j->light, &desc, &j->reference[index]);
}

/// From the folder of references, where it is there; into it, if not.
static rsv_status get_reference(judge *j, uint32_t index)
{
    char path[PATH_MAX] = "";
    if (j->bench->cache)
        snprintf(path, sizeof path, "%s/%s-%s-%ux%u-%uspp-%u.exr", j->bench->cache, j->name,
            cli_quality_names[j->bench->quality], j->width, j->height, j->bench->reference_samples,
            index);
    if (path[0] && access(path, R_OK) == 0)
        return rsv_image_read(j->context, path, &j->reference[index]);
    rsv_status status = render_reference(j, index);
    if (status == RSV_OK && path[0]) status = rsv_image_write(j->reference[index], path, 0);
    return status;
}

/// Compares the last frame with the references. @param name prefix of the figures in the result
static rsv_status judge_shown(const judge *j, const char *name, cJSON *result)
{
    static const uint32_t layers[2] = { 0 };
    rsv_image *half[3] = { NULL };
    rsv_image_judgement judgement;
    rsv_image_difference difference[2] = { { 0 } };
    char key[64];
    rsv_status status = shrink(j->context, j->shown, &half[2]);
    for (int k = 0; k < 2 && status == RSV_OK; k++)
        status = shrink(j->context, j->reference[k], &half[k]);
    const rsv_image *pair[2] = { half[0], half[1] };
    if (status == RSV_OK) status = rsv_image_judge(pair, layers, half[2], 0, &judgement);
    for (int k = 0; k < 2 && status == RSV_OK; k++)
        status = rsv_image_compare(half[k], 0, half[2], 0, &difference[k]);
    for (int k = 0; k < 3; k++)
        rsv_image_destroy(half[k]);
    if (status != RSV_OK) return status;
    snprintf(key, sizeof key, "%s_mse", name);
    cJSON_AddNumberToObject(result, key, judgement.relative_mse);
    snprintf(key, sizeof key, "%s_mean", name);
    cJSON_AddNumberToObject(
        result, key, 0.5 * (difference[0].mean_ratio + difference[1].mean_ratio));
    return RSV_OK;
}

// ---- judgements ---------------------------------------------------------------------------------

static rsv_status fly(judge *j, const cli_flight *flight)
{
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k <= moving_frames && status == RSV_OK; k++) {
        rsv_camera camera = cli_flight_camera(flight, k);
        status = show(j, &camera);
        if (k + 4 > moving_frames) paste(j, k + 3 - moving_frames, j->shown);
    }
    return status;
}

/// RMS of the difference as a screen shows it, clipped at white, over the mean of the picture.
static double visible_change(const rsv_image *a, const rsv_image *b)
{
    const rsv_rgb *p = rsv_image_const_pixels(a, 0), *q = rsv_image_const_pixels(b, 0);
    double squares = 0, sum = 0;
    size_t count = 3 * (size_t)rsv_image_width(a) * rsv_image_height(a);
    for (size_t k = 0; k < count; k++) {
        double x = fmin((double)(&p->r)[k], 1), y = fmin((double)(&q->r)[k], 1);
        squares += (x - y) * (x - y);
        sum += y;
    }
    return sum > 0 ? sqrt(squares * (double)count) / sum : 0;
}

static rsv_status rest(judge *j, cJSON *result)
{
    double flicker[resting_frames];
    rsv_image *before = NULL;
    rsv_status status = rsv_image_create(j->context, j->width, j->height, 1, &before);
    for (int k = 0; k < resting_frames && status == RSV_OK; k++) {
        rsv_image *other = before;
        before = j->shown;
        j->shown = other;
        status = show(j, &j->camera);
        if (status == RSV_OK) flicker[k] = visible_change(before, j->shown);
    }
    rsv_image_destroy(before);
    if (status != RSV_OK) return status;
    cJSON_AddNumberToObject(result, "flicker_first", flicker[0]);
    cJSON_AddNumberToObject(result, "flicker", cli_median(flicker, flicker_frames));
    return RSV_OK;
}

static rsv_status judge_flight(judge *j, const cli_flight *flight, cJSON *result)
{
    rsv_camera elsewhere = cli_flight_camera(flight, moving_frames + cut);
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < 2 && status == RSV_OK; k++)
        status = get_reference(j, k);
    if (status == RSV_OK) status = fly(j, flight);
    if (status == RSV_OK) status = judge_shown(j, "moving", result);
    if (status == RSV_OK) status = rest(j, result);
    if (status == RSV_OK) status = judge_shown(j, "resting", result);
    if (status == RSV_OK) paste(j, strip_columns - 2, j->shown);
    if (status == RSV_OK) paste(j, strip_columns - 1, j->reference[0]);
    if (status == RSV_OK) status = show(j, &elsewhere);
    if (status == RSV_OK) status = show(j, &j->camera);
    return status == RSV_OK ? judge_shown(j, "cut", result) : status;
}

static rsv_status write_strip(const judge *j, cJSON *result)
{
    char path[PATH_MAX];
    if (!j->strip) return RSV_OK;
    snprintf(path, sizeof path, "%s/%s.png", j->bench->strips, j->name);
    cJSON_AddStringToObject(result, "strip", path);
    return rsv_image_write(j->strip, path, 0);
}

static rsv_status create_judge(judge *j)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = j->width;
    desc.height = j->height;
    desc.gloss = (rsv_frame_gloss)j->bench->gloss;
    desc.rest = RSV_REST_FINAL;
    rsv_status status = rsv_frame_renderer_create(j->light, &desc, &j->renderer);
    if (status == RSV_OK) status = rsv_image_create(j->context, j->width, j->height, 1, &j->shown);
    if (status == RSV_OK && j->bench->strips)
        status = rsv_image_create(j->context, strip_columns * j->width, j->height, 1, &j->strip);
    return status;
}

static void destroy_judge(judge *j)
{
    rsv_frame_renderer_destroy(j->renderer);
    rsv_image_destroy(j->shown);
    rsv_image_destroy(j->strip);
    rsv_image_destroy(j->reference[0]);
    rsv_image_destroy(j->reference[1]);
}

rsv_status cli_judge_frames(
    const cli_bench_task *bench, const rsv_light *light, const char *name, cJSON *result)
{
    const rsv_scene *scene = rsv_light_scene(light);
    cli_flight flight;
    judge j = { .bench = bench,
        .light = light,
        .name = name,
        .context = rsv_scene_get_context(scene),
        .width = bench->judged_size.width,
        .height = bench->judged_size.height };
    rsv_status status = cli_flight_plan(scene, &flight);
    if (status == RSV_OK) status = create_judge(&j);
    if (status == RSV_OK) {
        j.camera = cli_flight_camera(&flight, moving_frames);
        status = judge_flight(&j, &flight, result);
    }
    if (status == RSV_OK) status = write_strip(&j, result);
    destroy_judge(&j);
    return status;
}
