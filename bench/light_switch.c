/// A light that is dimmed while frames are shown.
#include "judged_frames.h"

#include "resolvent/frame.h"
#include "resolvent/relight.h"

#include <cJSON.h>
#include <math.h>
#include <stdlib.h>

/// Number of frames after which no trace of the old light may be left, and number of frames that the new light alone
/// gets.
enum { most_steps = 200, remnant_frames = 3 };

/// Milliseconds of a frame that orders of light may take, as in `resolvent view`.
static const double budget_ms = 8;

typedef struct switched {
    rsv_light *light;
    rsv_relighter *relighter;
    rsv_frame_renderer *renderer;
    rsv_frame_view view;
    size_t pixels;
    rsv_rgb *radiance; ///< [pixels]
} switched;

static rsv_status show(switched *s, uint32_t frames, double *mean)
{
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < frames && status == RSV_OK; k++)
        status = rsv_frame_render(s->renderer, &s->view, NULL);
    if (status != RSV_OK || !mean) return status;
    rsv_frame_radiance(s->renderer, 0, s->radiance);
    *mean = 0;
    for (size_t k = 0; k < s->pixels; k++)
        *mean += (double)s->radiance[k].r + (double)s->radiance[k].g + (double)s->radiance[k].b;
    return RSV_OK;
}

/// One more step of the light, and a frame that shows it. @param changed whether sources have changed just before
static rsv_status step(switched *s, bool changed, rsv_relight_progress *progress, double *mean)
{
    rsv_status status = rsv_relighter_step(s->relighter, budget_ms, progress);
    if (status != RSV_OK) return status;
    if (progress->orders || changed) rsv_frame_renderer_refresh(s->renderer);
    return show(s, 1, mean);
}

static rsv_status dim(switched *s, cJSON *result)
{
    const rsv_light_scale scale = { rsv_relighter_source(s->relighter, 0).name,
        { 0.25f, 0.25f, 0.25f } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = &scale, .light_count = 1 };
    rsv_relight_progress progress = { .converged = false };
    double started = cli_seconds(), third = 0, fresh = 0, done = 0;
    rsv_status status = rsv_relighter_change(s->relighter, &desc);
    for (uint32_t k = 0; k < most_steps && status == RSV_OK; k++) {
        status = step(s, k == 0, &progress, k < remnant_frames ? &third : NULL);
        if (k == 0) cJSON_AddNumberToObject(result, "switch_ms", 1e3 * (cli_seconds() - started));
        if (progress.converged && done == 0) done = cli_seconds();
        if (progress.converged && k + 1 >= remnant_frames) break;
    }
    if (status == RSV_OK) status = rsv_relighter_settle(s->relighter);
    if (status != RSV_OK) return status;
    cJSON_AddNumberToObject(result, "switch_done_ms", 1e3 * (done - started));
    rsv_frame_renderer_refresh(s->renderer);
    status = show(s, remnant_frames, &fresh);
    if (status == RSV_OK && fresh > 0)
        cJSON_AddNumberToObject(result, "remnant", fabs(third / fresh - 1));
    return status;
}

static rsv_status begin(switched *s, const cli_bench_task *bench)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = bench->frame_size.width;
    desc.height = bench->frame_size.height;
    desc.gloss = (rsv_frame_gloss)bench->gloss;
    rsv_status status = rsv_relighter_create(s->light, &s->relighter);
    if (status == RSV_OK) status = rsv_relighter_prepare(s->relighter);
    if (status == RSV_OK) status = rsv_frame_renderer_create(s->light, &desc, &s->renderer);
    s->radiance = calloc(s->pixels, sizeof *s->radiance);
    if (!s->radiance) status = RSV_ERROR_MEMORY;
    return status;
}

rsv_status cli_measure_switch(const cli_bench_task *bench, rsv_light *light, cJSON *result)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_light_scene(light));
    switched s = { .light = light,
        .view = { .camera = { scene->camera[0] } },
        .pixels = (size_t)bench->frame_size.width * bench->frame_size.height };
    rsv_status status = begin(&s, bench);
    if (status == RSV_OK) status = show(&s, 2, NULL);
    if (status == RSV_OK && rsv_relighter_source_count(s.relighter) > 0) status = dim(&s, result);
    rsv_frame_renderer_destroy(s.renderer);
    rsv_relighter_destroy(s.relighter);
    free(s.radiance);
    return status;
}
