#include "view_show.h"

#include "resolvent/update.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/// Frames that a change of lights takes.
#define FADE_FRAMES 8
/// Samples that are enough while something better is made.
#define SAMPLES_WHILE_MADE 16

bool cli_show_begin(cli_view_show *s, const cli_refiner_desc *desc, uint32_t threads)
{
    *s = (cli_view_show){
        .session = desc->session, .body = desc->body, .keeps_pace = desc->keeps_pace
    };
    rsv_status status = cli_sketch_create(desc->scene, threads, &s->sketch);
    if (status == RSV_OK && (s->refiner = cli_refiner_start(desc))) return true;
    rsv_light_destroy(desc->light);
    if (status != RSV_OK)
        cli_report_failure(desc->session, status);
    else
        cli_error("view: no thread could be started; use --record DIR to write frames instead");
    return false;
}

void cli_show_end(cli_view_show *s)
{
    cli_refiner_stop(s->refiner);
    cli_free_lit(&s->lit);
    cli_free_lit(&s->before);
    cli_sketch_destroy(s->sketch);
    free(s->old.pixel);
    *s = (cli_view_show){ 0 };
}

bool cli_show_is_lit(const cli_view_show *s) { return s->lit.frames != NULL; }

bool cli_show_is_complete(const cli_view_show *s) { return s->lit.relighter || s->lit.follows; }

static void note_event(cli_view_show *s, const char *name)
{
    if (s->event_count < CLI_SHOW_MOST_EVENTS)
        s->event[s->event_count++] =
            (cli_show_event){ name, cli_seconds(), (double)clock() / CLOCKS_PER_SEC };
}

// ---- from one light to the next -----------------------------------------------------------------

static void end_fade(cli_view_show *s)
{
    s->fade = 0;
    cli_free_lit(&s->before);
    cli_sketch_destroy(s->sketch);
    s->sketch = NULL;
}

/// Sets up the state. For a light without a relighter, it has no sources and materials.
static bool begin_state(const cli_view_show *s, cli_view_state *state)
{
    cli_view_state before = *state;
    uint32_t layers = 1 + rsv_light_order_count(s->lit.light);
    const rsv_scene *scene = rsv_light_scene(s->lit.light);
    bool good = cli_view_state_begin(s->lit.relighter, scene, layers, s->body, state);
    if (good) cli_view_state_continue(state, &before);
    cli_view_state_free(&before);
    return good;
}

static rsv_status adopt(cli_view_show *s, const cli_lit *better, cli_view_state *state)
{
    if (s->fade > 0 && cli_show_is_lit(s)) end_fade(s);
    s->before = s->lit;
    s->lit = *better;
    s->fade = FADE_FRAMES;
    return begin_state(s, state) ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status cli_show_update(cli_view_show *s, cli_view_state *state)
{
    cli_lit better;
    rsv_status status = RSV_OK;
    if (!s->refiner) return RSV_OK;
    bool done = cli_refiner_is_done(s->refiner); // before the last look
    if (cli_refiner_take(s->refiner, &better)) status = adopt(s, &better, state);
    if (cli_refiner_failure(s->refiner, s->message) != RSV_OK) s->failed = true;
    if (!done) return status;
    cli_refiner_stop(s->refiner);
    s->refiner = NULL;
    return status;
}

rsv_status cli_show_follow(
    cli_view_show *s, cli_view_state *state, const rsv_scene *scene, size_t most_triangles)
{
    if (s->fade > 0) end_fade(s);
    cli_view_frames_detach(s->lit.frames);
    rsv_relighter_destroy(s->lit.relighter);
    s->lit.relighter = NULL;
    s->lit.follows = true;
    rsv_status status = rsv_light_follow_part(s->lit.light, scene, most_triangles, NULL);
    if (status == RSV_OK) status = cli_view_frames_begin_again(s->lit.frames);
    if (status != RSV_OK && status != RSV_ERROR_UNSUPPORTED) return status;
    rsv_status made = begin_state(s, state) ? RSV_OK : RSV_ERROR_MEMORY;
    return status == RSV_OK ? made : status;
}

rsv_status cli_show_replace(cli_view_show *s, cli_view_state *state, rsv_light *light)
{
    const char *name = s->lit.name;
    if (s->fade > 0) end_fade(s);
    cli_free_lit(&s->lit);
    s->lit = (cli_lit){ .name = name, .light = light, .follows = true };
    rsv_status status = cli_view_frames_create(light, s->body, 0, &s->lit.frames);
    if (status != RSV_OK) return status;
    if (s->keeps_pace) cli_view_frames_keep_pace(s->lit.frames);
    return begin_state(s, state) ? RSV_OK : RSV_ERROR_MEMORY;
}

// ---- frames -------------------------------------------------------------------------------------

static bool fit_old(cli_canvas *old, const cli_canvas *canvas)
{
    if (old->pixel && old->width == canvas->width && old->height == canvas->height) return true;
    free(old->pixel);
    *old = (cli_canvas){ canvas->width, canvas->height,
        calloc((size_t)canvas->width * canvas->height, 4) };
    return old->pixel != NULL;
}

static bool same_vector(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_pose(const cli_view_pose *p, const cli_view_pose *q)
{
    const rsv_camera *a = &p->camera, *b = &q->camera;
    return p->width == q->width && p->height == q->height && p->exposure == q->exposure &&
           p->soft == q->soft && same_vector(a->position, b->position) &&
           same_vector(a->right, b->right) && same_vector(a->up, b->up) &&
           same_vector(a->forward, b->forward) && a->vertical_fov == b->vertical_fov &&
           a->vertical_extent == b->vertical_extent;
}

/// Draws the sketch into `old`, unless it is there already.
static void draw_sketch(cli_view_show *s, cli_view_state *state)
{
    const cli_view_pose pose = { state->camera, state->exposure, state->soft, s->old.width,
        s->old.height };
    s->sketch_rests = same_pose(&s->sketched, &pose);
    if (!s->sketch_rests) cli_sketch_draw(s->sketch, state, &s->old);
    s->sketched = pose;
}

/// @param share of the old picture
static void blend(const cli_canvas *old, float share, cli_canvas *canvas)
{
    int weight = (int)(256 * share);
    size_t count = 4 * (size_t)canvas->width * canvas->height;
    const uint8_t *from = (const uint8_t *)old->pixel;
    uint8_t *to = (uint8_t *)canvas->pixel;
    for (size_t k = 0; k < count; k++)
        to[k] = (uint8_t)((to[k] * (256 - weight) + from[k] * weight) >> 8);
}

/// Blends the previous light over the picture, less with every frame. Modes that show something else switch at once.
static rsv_status fade(cli_view_show *s, cli_view_state *state, cli_canvas *canvas)
{
    cli_view_timing timing;
    rsv_status status = RSV_OK;
    if (s->fade == 0) return RSV_OK;
    bool fades = state->mode == CLI_VIEW_OPERATOR && state->layer == RSV_NONE && !state->stereo &&
                 (s->before.frames || s->sketch);
    if (!fades || !fit_old(&s->old, canvas)) {
        end_fade(s);
        return RSV_OK;
    }
    if (s->before.frames)
        status = cli_view_frames_next(s->before.frames, state, &s->old, &timing);
    else
        draw_sketch(s, state);
    if (status == RSV_OK) blend(&s->old, (float)s->fade / (FADE_FRAMES + 1), canvas);
    if (--s->fade == 0) end_fade(s);
    return status;
}

static rsv_status show_sketch(cli_view_show *s, cli_view_state *state, cli_canvas *canvas)
{
    if (!fit_old(&s->old, canvas) || !s->old.pixel) return RSV_ERROR_MEMORY;
    draw_sketch(s, state);
    memcpy(canvas->pixel, s->old.pixel, (size_t)4 * canvas->width * canvas->height);
    return RSV_OK;
}

rsv_status cli_show_frame(
    cli_view_show *s, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing)
{
    double start = cli_seconds();
    rsv_status status = RSV_OK;
    const char *name = s->lit.frames ? s->lit.name : "sketch";
    *timing = (cli_view_timing){ .eyes = 1 };
    if (s->lit.frames)
        status = cli_view_frames_next(s->lit.frames, state, canvas, timing);
    else
        status = show_sketch(s, state, canvas);
    if (status == RSV_OK) status = fade(s, state, canvas);
    timing->total_ms = 1e3 * (cli_seconds() - start);
    if (s->event_count == 0 || s->event[s->event_count - 1].name != name) note_event(s, name);
    return status;
}

bool cli_show_at_rest(const cli_view_show *s)
{
    if (!s->lit.frames) return s->sketch_rests;
    if (s->fade > 0) return false;
    return cli_view_frames_at_rest(s->lit.frames) ||
           (s->refiner && cli_view_frames_samples(s->lit.frames) >= SAMPLES_WHILE_MADE);
}

void cli_show_yield(const cli_view_show *s, double frame_ms)
{
    if (!s->refiner) return;
    double share = s->lit.frames ? 0.5 : 1, least = s->lit.frames ? 2 : 16;
    double pause = 1e-3 * fmin(fmax(share * frame_ms, least), 100);
    struct timespec time = { 0, (long)(1e9 * pause) };
    nanosleep(&time, NULL);
}
