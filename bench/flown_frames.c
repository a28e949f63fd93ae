#include "flown_frames.h"

#include "camera_flight.h"
#include "resolvent/frame.h"
#include "resolvent/measure.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { most_frames = 120, least_frames = 3 };

/// Length of a flight if no number of frames is given.
static const double flight_seconds = 3;

double cli_processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// ---- the flight ---------------------------------------------------------------------------------

/// Triangles of the body in a built-in scene.
enum { body_triangles = 100000 };

static bool open_subject(const cli_bench_task *bench, cli_subject *subject)
{
    if (!rsv_scene_is_builtin(bench->scene) || bench->environment.path)
        return cli_open_subject(bench->session, bench->scene, &bench->environment, subject);
    *subject = (cli_subject){ .scene = cli_open_bench_body(bench, body_triangles) };
    return subject->scene != NULL;
}

bool cli_open_solved(const cli_bench_task *bench, cli_subject *subject, cJSON *result)
{
    double opened = cli_seconds();
    if (!open_subject(bench, subject)) return false;
    double started = cli_seconds();
    rsv_solve_desc desc = cli_bench_solve_desc(bench, bench->quality);
    rsv_status status = RSV_OK;
    if (!subject->solution) status = rsv_light_create(subject->scene, &desc, &subject->solution);
    if (status != RSV_OK) {
        cli_report_failure(bench->session, status);
        cli_close_subject(subject);
        return false;
    }
    cJSON_AddNumberToObject(
        result, "triangles", (double)rsv_scene_get_view(subject->scene)->triangle_count);
    cJSON_AddNumberToObject(
        result, "elements", (double)rsv_light_report(subject->solution)->elements);
    cJSON_AddNumberToObject(result, "load_s", started - opened);
    cJSON_AddNumberToObject(result, "solve_s", cli_seconds() - started);
    return true;
}

// ---- the flight ---------------------------------------------------------------------------------

typedef enum series { WHOLE, BARE, RATIO, CPU, CAMERA, PATHS, GLOSS, DISPLAY, SERIES } series;

typedef struct flight_log {
    double value[SERIES][CLI_MOST_FLOWN]; ///< [count] each, milliseconds or ratios
    uint32_t count;
    double first_ms, worst_ms;
    double cpu, bare_cpu; ///< milliseconds of all frames: the clock may be too coarse for one
    uint64_t path_rays, gloss_rays; ///< of the last frame
} flight_log;

static void note_frame(
    flight_log *log, const rsv_frame_stats *stats, double bare, double cpu, double bare_cpu)
{
    const double value[SERIES] = { [WHOLE] = stats->total_ms,
        [BARE] = bare,
        [RATIO] = stats->total_ms / bare,
        [CPU] = cpu,
        [CAMERA] = stats->camera_ms,
        [PATHS] = stats->path_ms,
        [GLOSS] = stats->gloss_ms,
        [DISPLAY] = stats->display_ms };
    for (int k = 0; k < SERIES; k++)
        log->value[k][log->count] = value[k];
    log->count++;
    log->cpu += cpu;
    log->bare_cpu += bare_cpu;
    log->worst_ms = fmax(log->worst_ms, stats->total_ms);
    log->path_rays = stats->path_rays;
    log->gloss_rays = stats->gloss_rays;
}

/// A frame, and the bare tracing of its camera rays right after.
static rsv_status fly_frame(
    rsv_frame_renderer *renderer, const cli_flight *flight, uint32_t frame, flight_log *log)
{
    rsv_frame_view view = { .camera = { cli_flight_camera(flight, frame) } };
    rsv_frame_stats stats;
    double start = cli_processor_seconds();
    rsv_status status = rsv_frame_render(renderer, &view, &stats);
    double rendered = cli_processor_seconds();
    if (status != RSV_OK) return status;
    double bare = 1e3 * rsv_frame_trace_only(renderer, &view);
    double traced = cli_processor_seconds();
    if (frame == 0)
        log->first_ms = stats.total_ms;
    else
        note_frame(log, &stats, bare, 1e3 * (rendered - start), 1e3 * (traced - rendered));
    return RSV_OK;
}

static bool flies_on(const flight_log *log, uint32_t frames, double started)
{
    if (frames) return log->count < frames && log->count < CLI_MOST_FLOWN;
    return log->count < least_frames ||
           (log->count < most_frames && cli_seconds() < started + flight_seconds);
}

static void report_flight(flight_log *log, cJSON *result)
{
    static const char *const name[SERIES] = { "median_ms", "bare_ms", "ratio", "cpu_ms", "camera",
        "paths", "gloss", "display" };
    cJSON_AddNumberToObject(result, "frames", log->count);
    cJSON_AddNumberToObject(result, "first_ms", log->first_ms);
    cJSON_AddNumberToObject(result, "worst_ms", log->worst_ms);
    for (int k = 0; k < CAMERA; k++)
        cJSON_AddNumberToObject(result, name[k], cli_median(log->value[k], log->count));
    cJSON_AddNumberToObject(result, "ratio_cpu", log->bare_cpu > 0 ? log->cpu / log->bare_cpu : 0);
    cJSON_AddNumberToObject(
        result, "frames_per_second", 1e3 / cli_json_number(result, "median_ms"));
    cJSON *stages = cJSON_AddObjectToObject(result, "stages_ms");
    for (int k = CAMERA; k < SERIES; k++)
        cJSON_AddNumberToObject(stages, name[k], cli_median(log->value[k], log->count));
    cJSON_AddNumberToObject(result, "path_rays", (double)log->path_rays);
    cJSON_AddNumberToObject(result, "gloss_rays", (double)log->gloss_rays);
}

static rsv_status fly(
    const rsv_light *light, rsv_frame_renderer *renderer, uint32_t frames, cJSON *result)
{
    cli_flight flight;
    rsv_status status = cli_flight_plan(rsv_light_scene(light), &flight);
    flight_log *log = calloc(1, sizeof *log);
    if (!log) return RSV_ERROR_MEMORY;
    double started = cli_seconds();
    for (uint32_t k = 0; status == RSV_OK && flies_on(log, frames, started); k++) {
        status = fly_frame(renderer, &flight, k, log);
        if (cli_interrupted()) status = RSV_ERROR_CANCELLED;
    }
    if (status == RSV_OK) report_flight(log, result);
    free(log);
    return status;
}

rsv_status cli_fly(const cli_bench_task *bench, const rsv_light *light, cJSON *result)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    rsv_frame_renderer *renderer = NULL;
    char text[32];
    desc.width = bench->frame_size.width;
    desc.height = bench->frame_size.height;
    desc.gloss = (rsv_frame_gloss)bench->gloss;
    double started = cli_seconds();
    rsv_status status = rsv_frame_renderer_create(light, &desc, &renderer);
    if (status != RSV_OK) return status;
    snprintf(text, sizeof text, "%ux%u", desc.width, desc.height);
    cJSON_AddStringToObject(result, "size", text);
    cJSON_AddNumberToObject(result, "renderer_s", cli_seconds() - started);
    cJSON_AddStringToObject(
        result, "instructions", rsv_instructions_name(rsv_frame_instructions(renderer)));
    status = fly(light, renderer, bench->frames, result);
    rsv_frame_renderer_destroy(renderer);
    return status;
}
