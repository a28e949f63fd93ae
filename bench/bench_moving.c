/// An object that moves from frame to frame: light that follows it, and light that is updated for each frame, compared
/// with solving each frame from scratch.
#include "benchmarks.h"
#include "light_difference.h"
#include "moved_scene.h"
#include "moving_scenes.h"

#include "resolvent/animation.h"
#include "resolvent/render.h"
#include "resolvent/update.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { DEFAULT_FRAMES = 8, POINTS = 600, LAGS = 3, PART = 400 };
static const uint32_t lag_frames[LAGS] = { 1, 2, 4 };

/// The scene before anything moves, and its moving objects.
typedef struct stage {
    const cli_bench_task *bench;
    rsv_scene *scene;
    cli_motion moves;
    uint32_t object; ///< the first that moves
    uint32_t frame_count;
    rsv_animation *animation; ///< of the file, which moves instead; NULL = none
} stage;

/// Readings of all frames at points that stay where they are.
typedef struct readings {
    double (*whole)[POINTS], (*followed)[POINTS]; ///< [frame_count] W/m2, luminance
    double *spent, *spent_updating, *spent_anew;  ///< [frame_count] s of a processor
    double *spent_in_parts;                  ///< [frame_count] the same, if there is an animation
    double *apart, *kept_rays, *kept_lights; ///< [frame_count]
    rsv_probe probe[POINTS];
} readings;

static double processor_seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static bool find_motion(stage *s)
{
    const cli_motion *known = cli_find_motion(s->bench->scene);
    if (known) {
        s->moves = *known;
        s->object = rsv_scene_find_object(s->scene, known->object);
        return s->object != RSV_NONE;
    }
    s->object = cli_find_movable_object(s->scene);
    if (s->object == RSV_NONE) return false;
    s->moves.shift.x = cli_object_extent(s->scene, s->object);
    return true;
}

/// One second of the animation has 30 frames.
static rsv_status scene_of_time(const stage *s, uint32_t frame, rsv_scene **scene)
{
    const rsv_clip *clip = rsv_animation_clip(s->animation, 0);
    return rsv_animation_scene(s->animation, RSV_NONE, clip->start + frame / 30.0, scene);
}

static rsv_status scene_of_frame(const stage *s, uint32_t frame, rsv_scene **scene)
{
    if (s->animation) return scene_of_time(s, frame, scene);
    const rsv_scene_view *view = rsv_scene_get_view(s->scene);
    float share = (float)frame / (float)(s->frame_count - 1);
    size_t count = 0;
    rsv_motion *motion = calloc(view->object_count, sizeof *motion);
    if (!motion) return RSV_ERROR_MEMORY;
    for (uint32_t k = s->object; k < view->object_count; k++)
        if (k == s->object ||
            (s->moves.object && strcmp(view->object_name[k], s->moves.object) == 0))
            motion[count++] = cli_motion_at(&s->moves, s->scene, k, share);
    rsv_status status = rsv_scene_move(s->scene, motion, count, scene);
    free(motion);
    return status;
}

/// On a lattice in the inner part of the scene; each reads the surface below it.
static void place_probes(const rsv_scene_view *view, rsv_probe *probe)
{
    static const double step[3] = { 0.8191725133961645, 0.6710436067037893, 0.5497004779019703 };
    const float low[3] = { view->bounds_min.x, view->bounds_min.y, view->bounds_min.z };
    const float high[3] = { view->bounds_max.x, view->bounds_max.y, view->bounds_max.z };
    for (size_t k = 0; k < POINTS; k++) {
        float at[3];
        for (int i = 0; i < 3; i++) {
            float u = (float)fmod(0.5 + (double)(k + 1) * step[i], 1);
            at[i] = low[i] + (0.05f + 0.9f * u) * (high[i] - low[i]);
        }
        probe[k] = (rsv_probe){ { at[0], at[1], at[2] }, { 0, 1, 0 } };
    }
}

static rsv_status read_light(const rsv_light *light, const rsv_probe *probe, double *luminance)
{
    rsv_probe_reading reading[POINTS];
    const rsv_probe_desc desc = { .size = sizeof desc, .mode = RSV_PROBE_LOOKUP, .samples = 32 };
    rsv_status status = rsv_probe_irradiance(light, &desc, probe, POINTS, reading);
    for (size_t k = 0; k < POINTS && status == RSV_OK; k++) {
        rsv_rgb e = reading[k].irradiance;
        luminance[k] = 0.2126 * (double)e.r + 0.7152 * (double)e.g + 0.0722 * (double)e.b;
    }
    return status;
}

static rsv_solve_desc describe(const stage *s)
{
    return cli_bench_solve_desc(s->bench, s->bench->quality);
}

/// Lights of one frame.
typedef struct frame_lights {
    rsv_light *followed; ///< stays from frame to frame; NULL = there is none yet
    rsv_light *in_parts; ///< the same, of which PART triangles have their turn in a frame
    rsv_light *updated, *whole;
} frame_lights;

/// The first frame's light is a whole one, which follows from then on.
static rsv_status follow(
    const stage *s, const rsv_scene *scene, frame_lights *l, rsv_update_report *kept)
{
    const rsv_solve_desc desc = describe(s);
    rsv_status status = RSV_OK;
    if (!l->followed) status = rsv_light_create(s->scene, &desc, &l->followed);
    return status == RSV_OK ? rsv_light_follow(l->followed, scene, kept) : status;
}

/// The same in parts, if an animation deforms what moves.
static rsv_status follow_in_parts(
    const stage *s, uint32_t k, const rsv_scene *scene, frame_lights *l, readings *r)
{
    rsv_status status = RSV_OK;
    if (!s->animation) return RSV_OK;
    const rsv_solve_desc desc = describe(s);
    if (!l->in_parts) status = rsv_light_create(s->scene, &desc, &l->in_parts);
    double start = processor_seconds();
    if (!status) status = rsv_light_follow_part(l->in_parts, scene, PART, NULL);
    r->spent_in_parts[k] = processor_seconds() - start;
    return status;
}

static rsv_status solve_frame(const stage *s, uint32_t k, const rsv_scene *scene,
    rsv_update_store *store, frame_lights *l, readings *r)
{
    const rsv_solve_desc desc = describe(s);
    rsv_update_report kept = { 0 };
    rsv_status status;
    double start = processor_seconds();
    status = follow(s, scene, l, &kept);
    double followed = processor_seconds();
    if (!status) status = rsv_operator_update(scene, &desc, store, &l->updated, NULL);
    double between = processor_seconds();
    if (!status) status = rsv_light_create(scene, &desc, &l->whole);
    r->spent[k] = followed - start;
    r->spent_updating[k] = between - followed;
    r->spent_anew[k] = processor_seconds() - between;
    if (!status) r->kept_rays[k] = (double)kept.kept_row_rays / (double)kept.row_rays;
    if (!status) r->kept_lights[k] = (double)kept.kept_lit_elements / (double)kept.lit_elements;
    return status;
}

static rsv_status run_frame(
    const stage *s, uint32_t k, rsv_update_store *store, frame_lights *l, readings *r)
{
    rsv_scene *scene = NULL;
    rsv_status status = scene_of_frame(s, k, &scene);
    if (!status) status = solve_frame(s, k, scene, store, l, r);
    if (!status) status = follow_in_parts(s, k, scene, l, r);
    if (!status) status = read_light(l->followed, r->probe, r->followed[k]);
    if (!status) status = read_light(l->whole, r->probe, r->whole[k]);
    if (!status) r->apart[k] = cli_light_difference(l->whole, l->followed);
    rsv_light_destroy(l->updated);
    rsv_light_destroy(l->whole);
    l->updated = l->whole = NULL;
    rsv_scene_destroy(scene);
    return status;
}

/// RMS difference of readings, over their RMS.
static double difference(const double *a, const double *b)
{
    double squares = 0, all = 0;
    for (size_t k = 0; k < POINTS; k++) {
        squares += (a[k] - b[k]) * (a[k] - b[k]);
        all += b[k] * b[k];
    }
    return sqrt(squares / all);
}

static double mean_of(const double *value, size_t count)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += value[k];
    return sum / (double)count;
}

/// Error of light that lags behind, averaged over the frames.
static void add_lags(const stage *s, const readings *r, cJSON *result)
{
    for (int n = 0; n < LAGS; n++) {
        char name[32];
        double sum = 0;
        uint32_t lag = lag_frames[n], count = 0;
        for (uint32_t k = lag; k < s->frame_count; k++, count++)
            sum += difference(r->followed[k - lag], r->whole[k]);
        snprintf(name, sizeof name, "lag_%u", lag);
        if (count)
            cJSON_AddNumberToObject(result, name, sum / count);
        else
            cJSON_AddNullToObject(result, name);
    }
}

static void add_results(const stage *s, readings *r, cJSON *result)
{
    size_t moves = s->frame_count - 1;
    double mean = 0;
    for (uint32_t k = 1; k < s->frame_count; k++)
        mean = fmax(mean, fabs(mean_of(r->followed[k], POINTS) / mean_of(r->whole[k], POINTS) - 1));
    cJSON_AddNumberToObject(result, "frames", s->frame_count);
    double follow = cli_median(r->spent + 1, moves), anew = cli_median(r->spent_anew + 1, moves),
           update = cli_median(r->spent_updating + 1, moves);
    cJSON_AddNumberToObject(result, "follow_ms", 1e3 * follow);
    cJSON_AddNumberToObject(result, "update_ms", 1e3 * update);
    cJSON_AddNumberToObject(result, "anew_ms", 1e3 * anew);
    if (s->animation)
        cJSON_AddNumberToObject(result, "parts_ms", 1e3 * cli_median(r->spent_in_parts + 1, moves));
    cJSON_AddNumberToObject(result, "times_cheaper", anew / follow);
    cJSON_AddNumberToObject(result, "update_times_cheaper", anew / update);
    cJSON_AddNumberToObject(result, "kept_rays", mean_of(r->kept_rays + 1, moves));
    cJSON_AddNumberToObject(result, "kept_lights", mean_of(r->kept_lights + 1, moves));
    cJSON_AddNumberToObject(result, "difference", mean_of(r->apart + 1, moves));
    cJSON_AddNumberToObject(result, "worst_mean_difference", mean);
    add_lags(s, r, result);
}

static bool allocate(readings *r, size_t frames)
{
    r->whole = calloc(frames, sizeof *r->whole);
    r->followed = calloc(frames, sizeof *r->followed);
    r->spent = calloc(7 * frames, sizeof *r->spent);
    if (!r->whole || !r->followed || !r->spent) return false;
    r->spent_anew = r->spent + frames;
    r->apart = r->spent + 2 * frames;
    r->kept_rays = r->spent + 3 * frames;
    r->kept_lights = r->spent + 4 * frames;
    r->spent_updating = r->spent + 5 * frames;
    r->spent_in_parts = r->spent + 6 * frames;
    return true;
}

static rsv_status measure(const stage *s, cJSON *result)
{
    static const readings none = { 0 };
    rsv_update_store *store = NULL;
    frame_lights lights = { NULL, NULL, NULL, NULL };
    readings *r = malloc(sizeof *r);
    if (!r) return RSV_ERROR_MEMORY;
    *r = none;
    rsv_status status = allocate(r, s->frame_count) ? RSV_OK : RSV_ERROR_MEMORY;
    place_probes(rsv_scene_get_view(s->scene), r->probe);
    if (!status) status = rsv_update_store_create(s->bench->session->context, &store);
    for (uint32_t k = 0; k < s->frame_count && !status; k++) {
        cli_progress_part(&s->bench->session->progress, "frame", k + 1, s->frame_count);
        status = run_frame(s, k, store, &lights, r);
    }
    if (!status) add_results(s, r, result);
    rsv_light_destroy(lights.followed);
    rsv_light_destroy(lights.in_parts);
    rsv_update_store_destroy(store);
    free(r->whole);
    free(r->followed);
    free(r->spent);
    free(r);
    return status;
}

/// The scene, with the animation if it is an animated file.
static rsv_status open_stage(stage *s)
{
    rsv_context *context = s->bench->session->context;
    const char *end = strrchr(s->bench->scene, '.');
    if (!end || (strcmp(end, ".glb") != 0 && strcmp(end, ".gltf") != 0)) return RSV_OK;
    rsv_status status = rsv_animation_open(context, s->bench->scene, NULL, &s->animation);
    if (status != RSV_OK) return status;
    if (rsv_animation_clip_count(s->animation) > 0) return scene_of_time(s, 0, &s->scene);
    rsv_animation_destroy(s->animation);
    s->animation = NULL;
    return RSV_OK;
}

static rsv_status run(stage *s, cJSON *result)
{
    if (!s->animation && !find_motion(s)) return RSV_ERROR_SCENE;
    const char *object =
        s->animation ? "animation" : rsv_scene_get_view(s->scene)->object_name[s->object];
    cJSON_AddStringToObject(result, "object", object);
    return measure(s, result);
}

bool cli_bench_moving(const cli_bench_task *bench, cJSON *result)
{
    stage s = { .bench = bench, .frame_count = bench->frames ? bench->frames : DEFAULT_FRAMES };
    if (s.frame_count < 2) s.frame_count = 2;
    rsv_status status = open_stage(&s);
    if (status == RSV_OK && !s.scene && !(s.scene = cli_open_bench_scene(bench))) return false;
    if (status == RSV_OK) status = run(&s, result);
    rsv_scene_destroy(s.scene);
    rsv_animation_destroy(s.animation);
    if (status == RSV_ERROR_SCENE || status == RSV_ERROR_UNSUPPORTED)
        cli_error("bench moving: '%s' has no object small enough to be moved", bench->scene);
    else if (status != RSV_OK)
        cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_moving(const cJSON *result)
{
    printf("  '%s' moves through %.0f frames\n",
        cJSON_GetStringValue(cJSON_GetObjectItem(result, "object")),
        cli_json_number(result, "frames"));
    printf(
        "  a frame followed     %8.0f ms of a processor; %.1f %% of the rows' rays kept, %.1f %% "
        "of the elements' direct light\n",
        cli_json_number(result, "follow_ms"), 100 * cli_json_number(result, "kept_rays"),
        100 * cli_json_number(result, "kept_lights"));
    if (cJSON_GetObjectItem(result, "parts_ms"))
        printf("  in parts of %d triangles %5.0f ms\n", PART, cli_json_number(result, "parts_ms"));
    printf("  a frame solved anew  %8.0f ms: %.1f times as much\n",
        cli_json_number(result, "anew_ms"), cli_json_number(result, "times_cheaper"));
    printf("  a frame updated      %8.0f ms: anew %.1f times as much\n",
        cli_json_number(result, "update_ms"), cli_json_number(result, "update_times_cheaper"));
    printf("  differ by              %.2f %% RMS, means at most by %.2f %%\n",
        100 * cli_json_number(result, "difference"),
        100 * cli_json_number(result, "worst_mean_difference"));
    for (int n = 0; n < LAGS; n++) {
        char name[32];
        snprintf(name, sizeof name, "lag_%u", lag_frames[n]);
        double lag = cli_json_number(result, name); // not a number where there are too few frames
        if (lag >= 0)
            printf("  light of %u frames before is off by %.1f %%\n", lag_frames[n], 100 * lag);
    }
}

bool cli_write_moving_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "frames", "follow_ms", "parts_ms", "update_ms",
        "anew_ms", "times_cheaper", "update_times_cheaper", "kept_rays", "kept_lights",
        "difference", "worst_mean_difference", "lag_1", "lag_2", "lag_4" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}
