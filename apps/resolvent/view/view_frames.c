#include "view_frames.h"

#include "../progress.h"
#include "view_pace.h"
#include "view_still.h"

#include "resolvent/frame.h"
#include "resolvent/mover.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Frames without a change after which the light is made exact.
#define FRAMES_TO_SETTLE 8
/// Number of samples after which further ones are invisible.
#define ENOUGH_SAMPLES 1024

struct cli_view_frames {
    rsv_light *solution;
    rsv_relighter *relighter; ///< NULL = the light stays as it is
    double budget_ms;
    const rsv_scene *body;   ///< NULL = none
    rsv_mover *mover;        ///< of that
    uint32_t object_changes; ///< version of the state that the object was placed for
    cli_view_changes changes;
    uint32_t light_changes; ///< version of the state that the light was computed for
    size_t added_count;     ///< lights that were added to it
    uint32_t replacements;  ///< version of its elements that pictures and mover use
    uint32_t quiet_frames;  ///< since the light last changed
    bool converged;

    uint32_t width, height, eyes; ///< of one eye's picture
    rsv_frame_renderer *renderer;
    cli_still still[RSV_MAX_EYES];
    cli_view_mode mode;              ///< of the last frame
    rsv_camera camera[RSV_MAX_EYES]; ///< of the last frame
    bool shows_still;
    uint32_t samples;
    cli_view_pace pace;
};

static double now_ms(void) { return 1e3 * cli_seconds(); }

static rsv_context *context_of(const cli_view_frames *f)
{
    return rsv_scene_get_context(rsv_light_scene(f->solution));
}

rsv_status cli_view_frames_create(
    rsv_light *solution, const rsv_scene *body, double budget_ms, cli_view_frames **frames)
{
    cli_view_frames *f = calloc(1, sizeof *f);
    if (!f) return RSV_ERROR_MEMORY;
    f->solution = solution;
    f->body = body;
    f->budget_ms = budget_ms;
    f->converged = true;
    f->pace.coarseness = 1;
    rsv_status status = body ? rsv_mover_create(solution, body, NULL, &f->mover) : RSV_OK;
    if (status == RSV_OK)
        *frames = f;
    else
        cli_view_frames_destroy(f);
    return status;
}

rsv_status cli_view_frames_attach(cli_view_frames *f, rsv_relighter *relighter)
{
    size_t items = rsv_relighter_source_count(relighter) +
                   rsv_scene_get_view(rsv_light_scene(f->solution))->material_count +
                   CLI_VIEW_MOST_ADDED;
    f->changes.light = calloc(items, sizeof *f->changes.light);
    f->changes.albedo = calloc(items, sizeof *f->changes.albedo);
    f->changes.move = calloc(items, sizeof *f->changes.move);
    if (!f->changes.light || !f->changes.albedo || !f->changes.move) return RSV_ERROR_MEMORY;
    f->relighter = relighter;
    f->replacements = rsv_relighter_replacements(relighter);
    return RSV_OK;
}

static void free_pictures(cli_view_frames *f)
{
    rsv_frame_renderer_destroy(f->renderer);
    f->renderer = NULL;
    for (int k = 0; k < RSV_MAX_EYES; k++)
        cli_still_free(&f->still[k]);
}

void cli_view_frames_destroy(cli_view_frames *f)
{
    if (!f) return;
    free_pictures(f);
    rsv_mover_destroy(f->mover);
    free(f->changes.light);
    free(f->changes.albedo);
    free(f->changes.move);
    free(f);
}

/// Pictures of the right size. @param width of one eye's
static rsv_status fit(cli_view_frames *f, uint32_t eyes, uint32_t width, uint32_t height)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    if (f->renderer && width == f->width && height == f->height && eyes == f->eyes) return RSV_OK;
    free_pictures(f);
    desc.width = f->width = width;
    desc.height = f->height = height;
    desc.eyes = f->eyes = eyes;
    desc.rest = RSV_REST_FINAL;
    rsv_status status = rsv_frame_renderer_create(f->solution, &desc, &f->renderer);
    if (status == RSV_OK) rsv_frame_renderer_put(f->renderer, f->mover);
    for (uint32_t k = 0; k < eyes && status == RSV_OK; k++)
        status = cli_still_resize(f->solution, width, f->height, &f->still[k]);
    return status;
}

void cli_view_frames_keep_pace(cli_view_frames *f) { f->pace.varies = true; }

rsv_status cli_view_frames_prepare(cli_view_frames *f, uint32_t width, uint32_t height)
{
    return fit(f, 1, width, height);
}

// ---- light ------------------------------------------------------------------------------------------

static void start_over(cli_view_frames *f)
{
    for (uint32_t k = 0; k < f->eyes; k++)
        f->still[k].samples = 0;
}

static rsv_status add_lights(cli_view_frames *f, const cli_view_state *state)
{
    rsv_status status = RSV_OK;
    while (status == RSV_OK && f->added_count < state->added_count) {
        rsv_punctual_light light = cli_view_added_light(state, f->added_count++);
        status = rsv_relighter_add_light(f->relighter, &light);
    }
    return status;
}

void cli_view_frames_detach(cli_view_frames *f)
{
    f->relighter = NULL;
    f->converged = true;
}

rsv_status cli_view_frames_begin_again(cli_view_frames *f)
{
    rsv_status status = RSV_OK;
    free_pictures(f);
    f->samples = 0;
    if (f->mover) {
        rsv_mover_destroy(f->mover);
        f->mover = NULL;
        f->object_changes = UINT32_MAX; // forces it to be placed again
        status = rsv_mover_create(f->solution, f->body, NULL, &f->mover);
    }
    return status;
}

/// Shows the present light in pictures and mover; if its elements were replaced, sets both up again.
static rsv_status show_light(cli_view_frames *f)
{
    uint32_t replacements = rsv_relighter_replacements(f->relighter);
    if (replacements == f->replacements) {
        rsv_frame_renderer_refresh(f->renderer);
        start_over(f);
        if (f->mover) rsv_mover_refresh(f->mover);
        return RSV_OK;
    }
    f->replacements = replacements;
    rsv_status status = cli_view_frames_begin_again(f);
    return status == RSV_OK ? fit(f, f->eyes, f->width, f->height) : status;
}

/// Changes the light to match the state. If it refuses, the state is reset.
static rsv_status change_light(cli_view_frames *f, cli_view_state *state)
{
    rsv_relight_desc desc = cli_view_relighting(state, &f->changes);
    f->light_changes = state->light_changes;
    rsv_status status = add_lights(f, state);
    if (status == RSV_OK) status = rsv_relighter_change(f->relighter, &desc);
    if (status == RSV_OK)
        cli_view_note_taken(state);
    else
        cli_view_take_back(state);
    return status;
}

/// Follows the state, one step per frame, and makes all exact once nothing has changed for some frames.
static rsv_status update_light(cli_view_frames *f, cli_view_state *state, cli_view_timing *timing)
{
    rsv_status status = RSV_OK;
    rsv_relight_progress progress = { .converged = true };
    double start = now_ms();
    if (!f->relighter) return RSV_OK;
    bool changed = state->light_changes != f->light_changes;
    f->quiet_frames = changed ? 0 : f->quiet_frames + 1;
    if (changed) {
        status = change_light(f, state);
        f->converged = false;
    }
    if (status == RSV_OK && !f->converged)
        status = rsv_relighter_step(f->relighter, f->budget_ms, &progress);
    bool settles = f->converged && f->quiet_frames >= FRAMES_TO_SETTLE &&
                   !rsv_relighter_is_settled(f->relighter);
    if (status == RSV_OK && settles) status = rsv_relighter_refine(f->relighter);
    bool stepped = progress.orders > 0;
    f->converged = f->converged || progress.converged;
    timing->residual = progress.residual;
    timing->light_ms = now_ms() - start;
    if (status != RSV_OK || !(stepped || settles || changed)) return status;
    start = now_ms();
    status = show_light(f);
    timing->refresh_ms = now_ms() - start;
    return status;
}

/// Moves the object to its new place.
static rsv_status update_object(
    cli_view_frames *f, const cli_view_state *state, cli_view_timing *timing)
{
    if (!f->mover || state->object_changes == f->object_changes) return RSV_OK;
    double start = now_ms();
    rsv_status status =
        rsv_mover_place(f->mover, state->item[state->object].offset, state->object_turn);
    if (status != RSV_OK) return status;
    f->object_changes = state->object_changes;
    rsv_frame_renderer_put(f->renderer, f->mover);
    timing->light_ms += now_ms() - start;
    return RSV_OK;
}

// ---- pictures ---------------------------------------------------------------------------------------

static void aim(const cli_view_frames *f, const cli_view_state *state, rsv_camera camera[])
{
    camera[0] = state->camera;
    for (uint32_t k = 0; k < f->eyes && f->eyes > 1; k++)
        camera[k] = rsv_camera_eye(&state->camera, k, state->separation);
}

/// Whether frames go on where they were; pictures at rest start over if not.
static bool keep_still(cli_view_frames *f, const cli_view_state *state, const rsv_camera camera[])
{
    bool same = state->mode == f->mode && f->samples > 0 &&
                memcmp(camera, f->camera, f->eyes * sizeof *camera) == 0;
    f->mode = state->mode;
    memcpy(f->camera, camera, f->eyes * sizeof *camera);
    if (!same) start_over(f);
    return same;
}

static rsv_status render_frame(cli_view_frames *f, const cli_view_state *state,
    const rsv_camera camera[], cli_canvas *canvas, cli_view_timing *timing)
{
    rsv_frame_view view = { .exposure = state->exposure, .soft = state->soft };
    rsv_frame_stats stats;
    memcpy(view.camera, camera, f->eyes * sizeof *camera);
    rsv_frame_renderer_show(f->renderer, state->layer);
    uint32_t coarse = timing->coarseness = f->pace.coarseness;
    rsv_status status = rsv_frame_renderer_resize(
        f->renderer, (f->width + coarse - 1) / coarse, (f->height + coarse - 1) / coarse);
    if (status == RSV_OK) status = rsv_frame_render(f->renderer, &view, &stats);
    if (status != RSV_OK) return status;
    timing->camera_ms = stats.camera_ms;
    timing->path_ms = stats.path_ms;
    timing->gloss_ms = stats.gloss_ms;
    timing->display_ms = stats.display_ms;
    timing->path_rays = stats.path_rays;
    f->samples = stats.samples;
    for (uint32_t k = 0; k < f->eyes; k++)
        cli_view_enlarge(rsv_frame_pixels(f->renderer, k), f->pace.coarseness, f->width, f->height,
            k * f->width, canvas);
    cli_view_pace_note(&f->pace, stats.total_ms);
    return RSV_OK;
}

/// Starts mode final from what the frames have accumulated at this place.
static rsv_status begin_still(cli_view_frames *f, const cli_view_state *state,
    const rsv_camera camera[], cli_canvas *canvas, cli_view_timing *timing)
{
    if (state->mode != CLI_VIEW_FINAL || f->still[0].samples > 0) return RSV_OK;
    cli_view_state all = *state;
    all.layer = RSV_NONE;
    rsv_status status = render_frame(f, &all, camera, canvas, timing);
    for (uint32_t k = 0; k < f->eyes && status == RSV_OK; k++)
        rsv_frame_radiance(f->renderer, k, f->still[k].known);
    return status;
}

static rsv_status render_still(cli_view_frames *f, const cli_view_state *state,
    const rsv_camera camera[], cli_canvas *canvas, cli_view_timing *timing)
{
    double start = now_ms();
    rsv_status status = begin_still(f, state, camera, canvas, timing);
    bool measures = state->mode == CLI_VIEW_ERROR; // its colours mean numbers: no exposure
    for (uint32_t k = 0; k < f->eyes && status == RSV_OK; k++) {
        status = cli_still_add(&f->still[k], state->mode, &camera[k]);
        cli_still_show(&f->still[k], state->mode, measures ? 0 : state->exposure,
            state->soft && !measures, k * f->width, canvas);
    }
    f->samples = f->still[0].samples;
    timing->still_ms = now_ms() - start;
    return status;
}

rsv_status cli_view_frames_next(
    cli_view_frames *f, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing)
{
    double start = now_ms();
    rsv_camera camera[RSV_MAX_EYES];
    *timing = (cli_view_timing){ .samples = 0 };
    uint32_t eyes = state->stereo && canvas->width > 1 ? 2 : 1;
    rsv_status status = fit(f, eyes, canvas->width / eyes, canvas->height);
    if (status != RSV_OK) return status;
    state->aspect = (float)f->width / (float)f->height;
    status = update_light(f, state, timing);
    if (status == RSV_OK) status = update_object(f, state, timing);
    if (status != RSV_OK) return status;
    aim(f, state, camera);
    bool rests = keep_still(f, state, camera) && f->converged;
    cli_view_pace_begin(&f->pace, rests);
    bool occlusion = state->mode == CLI_VIEW_OCCLUSION || state->mode == CLI_VIEW_OCCLUSION_SCREEN;
    f->shows_still = state->mode != CLI_VIEW_OPERATOR && (rests || occlusion);
    status = f->shows_still ? render_still(f, state, camera, canvas, timing)
                            : render_frame(f, state, camera, canvas, timing);
    timing->samples = f->samples;
    timing->eyes = f->eyes;
    timing->total_ms = now_ms() - start;
    return status;
}

uint32_t cli_view_frames_samples(const cli_view_frames *f) { return f->samples; }

bool cli_view_frames_at_rest(const cli_view_frames *f)
{
    bool settled = !f->relighter || rsv_relighter_is_settled(f->relighter);
    return settled &&
           (f->shows_still ? cli_still_is_done(&f->still[0], f->mode)
                           : f->mode == CLI_VIEW_OPERATOR && f->samples >= ENOUGH_SAMPLES);
}

// ---- files ------------------------------------------------------------------------------------------

static float decoded(uint8_t code)
{
    float x = (float)code / 255;
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

static void copy_shown(const cli_canvas *canvas, rsv_image *image)
{
    rsv_rgb *out = rsv_image_pixels(image, 0);
    for (size_t k = 0; k < (size_t)canvas->width * canvas->height; k++)
        out[k] = (rsv_rgb){ decoded(canvas->pixel[k][0]), decoded(canvas->pixel[k][1]),
            decoded(canvas->pixel[k][2]) };
}

static bool is_png(const char *path)
{
    const char *extension = strrchr(path, '.');
    return extension && strcmp(extension, ".png") == 0;
}

/// Eyes side by side, in linear radiance.
static rsv_status copy_radiance(const cli_view_frames *f, rsv_image *image)
{
    rsv_rgb *eye = malloc((size_t)f->width * f->height * sizeof *eye);
    if (!eye) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < f->eyes; k++) {
        const rsv_rgb *from = f->shows_still ? f->still[k].radiance : eye;
        if (!f->shows_still) rsv_frame_radiance(f->renderer, k, eye);
        uint32_t coarse = f->shows_still ? 1 : f->pace.coarseness;
        size_t across = (f->width + coarse - 1) / coarse;
        rsv_rgb *to = rsv_image_pixels(image, 0) + (size_t)k * f->width;
        for (uint32_t y = 0; y < f->height; y++, to += rsv_image_width(image))
            for (uint32_t x = 0; x < f->width; x++)
                to[x] = from[y / coarse * across + x / coarse];
    }
    free(eye);
    return RSV_OK;
}

rsv_status cli_view_save_picture(
    const cli_view_frames *f, const cli_canvas *canvas, const char *path)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_create(context_of(f), canvas->width, canvas->height, 1, &image);
    if (status == RSV_OK && is_png(path))
        copy_shown(canvas, image);
    else if (status == RSV_OK)
        status = copy_radiance(f, image);
    if (status == RSV_OK) status = rsv_image_write(image, path, 0);
    rsv_image_destroy(image);
    return status;
}
