/// Frames per second: whole frames beside bare ray tracing, stereo, and whether frames leave anything behind.
#include "bars.h"
#include "benchmarks.h"

#include "resolvent/frame.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum { steady_frames = 10000, body_triangles = 100000 };

/// The camera swings this far to either side, so that no frame rests.
static const float swing = 0.02f; // metres

static const float eye_distance = 0.063f;

/// The view of frame `index`, from eyes side by side.
static rsv_frame_view view_at(const rsv_scene *scene, uint32_t index)
{
    rsv_camera camera = rsv_scene_get_view(scene)->camera[0];
    float side = swing * sinf(0.1f * (float)(index + 1));
    camera.position.x += side * camera.right.x;
    camera.position.y += side * camera.right.y;
    camera.position.z += side * camera.right.z;
    return (rsv_frame_view){ .camera = { rsv_camera_eye(&camera, 0, eye_distance),
                                 rsv_camera_eye(&camera, 1, eye_distance) } };
}

static rsv_status create_renderer(const rsv_light *solution, uint32_t width, uint32_t height,
    uint32_t eyes, rsv_frame_renderer **renderer)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = width;
    desc.height = height;
    desc.eyes = eyes;
    return rsv_frame_renderer_create(solution, &desc, renderer);
}

static double seconds_of_frame(rsv_frame_renderer *renderer, const rsv_frame_view *view)
{
    rsv_frame_stats stats;
    return rsv_frame_render(renderer, view, &stats) == RSV_OK ? 1e-3 * stats.total_ms : NAN;
}

/// Of all threads.
static double processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void add_median(cJSON *result, const char *name, double *values, uint32_t count)
{
    cJSON_AddNumberToObject(result, name, cli_median(values, count));
}

// ---- one view -----------------------------------------------------------------------------------

/// What neighbouring frames took: [frames] each, wall clock and processor time.
typedef struct frame_times {
    double *whole, *bare, *ratio, *whole_cpu, *ratio_cpu;
} frame_times;

static void add_times(cJSON *result, const frame_times *t, uint32_t frames)
{
    add_median(result, "frame_s", t->whole, frames);
    add_median(result, "frame_cpu_s", t->whole_cpu, frames);
    add_median(result, "tracing_s", t->bare, frames);
    add_median(result, "ratio_to_tracing", t->ratio, frames);
    add_median(result, "ratio_to_tracing_cpu", t->ratio_cpu, frames);
    cJSON_AddNumberToObject(result, "frames_per_second", 1 / cli_json_number(result, "frame_s"));
    cJSON_AddNumberToObject(result, "best_ms", 1e3 * t->whole[0]); // sorted by now
}

static void add_stages(cJSON *result, const rsv_frame_stats *stats)
{
    cJSON_AddNumberToObject(result, "path_rays", (double)stats->path_rays);
    cJSON_AddNumberToObject(result, "camera_ms", stats->camera_ms);
    cJSON_AddNumberToObject(result, "path_ms", stats->path_ms);
    cJSON_AddNumberToObject(result, "display_ms", stats->display_ms);
}

/// Whole frames and bare tracing by turns; ratios of neighbours.
static rsv_status measure_single(const rsv_light *solution, uint32_t frames, cJSON *result)
{
    rsv_frame_renderer *renderer = NULL;
    const rsv_scene *scene = rsv_light_scene(solution);
    rsv_status status = create_renderer(solution, 1280, 720, 1, &renderer);
    if (status != RSV_OK) return status;
    double *times = calloc(5 * frames, sizeof *times);
    if (!times) {
        rsv_frame_renderer_destroy(renderer);
        return RSV_ERROR_MEMORY;
    }
    frame_times t = { times, times + frames, times + 2 * frames, times + 3 * frames,
        times + 4 * frames };
    rsv_frame_stats stats = { 0 };
    for (uint32_t k = 0; k < frames && !cli_interrupted(); k++) {
        rsv_frame_view view = view_at(scene, k);
        double start = processor_seconds();
        t.bare[k] = rsv_frame_trace_only(renderer, &view);
        double traced = processor_seconds();
        rsv_frame_render(renderer, &view, &stats);
        t.whole_cpu[k] = processor_seconds() - traced;
        t.whole[k] = 1e-3 * stats.total_ms;
        t.ratio[k] = t.whole[k] / t.bare[k];
        t.ratio_cpu[k] = t.whole_cpu[k] / (traced - start);
    }
    cJSON_AddStringToObject(
        result, "instructions", rsv_instructions_name(rsv_frame_instructions(renderer)));
    add_times(result, &t, frames);
    add_stages(result, &stats);
    rsv_frame_renderer_destroy(renderer);
    free(times);
    return RSV_OK;
}

// ---- two eyes -----------------------------------------------------------------------------------

/// What the second eye adds to a frame of one, as a share of that.
static rsv_status measure_stereo(const rsv_light *solution, uint32_t frames, cJSON *result)
{
    rsv_frame_renderer *one = NULL, *two = NULL;
    const rsv_scene *scene = rsv_light_scene(solution);
    rsv_status status = create_renderer(solution, 1920, 1080, 1, &one);
    if (status == RSV_OK) status = create_renderer(solution, 1920, 1080, 2, &two);
    double *second = calloc(frames, sizeof *second);
    if (!second) status = RSV_ERROR_MEMORY;
    for (uint32_t k = 0; status == RSV_OK && k < frames && !cli_interrupted(); k++) {
        rsv_frame_view view = view_at(scene, k);
        double first = seconds_of_frame(one, &view), both = seconds_of_frame(two, &view);
        second[k] = (both - first) / first;
    }
    if (status == RSV_OK) add_median(result, "second_eye", second, frames);
    rsv_frame_renderer_destroy(one);
    rsv_frame_renderer_destroy(two);
    free(second);
    return status;
}

// ---- steady state -------------------------------------------------------------------------------

/// Bytes of memory in use; 0 where the system does not say.
static double resident_bytes(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    double pages = 0;
    if (!file) return 0;
    if (fscanf(file, "%*s %lf", &pages) != 1) pages = 0;
    fclose(file);
    return pages * (double)sysconf(_SC_PAGESIZE);
}

static rsv_status measure_steady_state(
    const cli_bench_task *bench, const rsv_light *solution, cJSON *result)
{
    rsv_frame_renderer *renderer = NULL;
    const rsv_scene *scene = rsv_light_scene(solution);
    rsv_status status = create_renderer(solution, 64, 36, 1, &renderer);
    if (status != RSV_OK) return status;
    uint64_t allocations = 0;
    double resident = 0;
    for (uint32_t k = 0; k < 100 + steady_frames && !cli_interrupted(); k++) {
        if (k == 100) { // threads have started
            allocations = bench->session->allocations;
            resident = resident_bytes();
        }
        rsv_frame_view view = view_at(scene, k);
        rsv_frame_render(renderer, &view, NULL);
    }
    cJSON_AddNumberToObject(result, "steady_frames", steady_frames);
    cJSON_AddNumberToObject(
        result, "allocations", (double)(bench->session->allocations - allocations));
    cJSON_AddNumberToObject(result, "grown_bytes", resident_bytes() - resident);
    rsv_frame_renderer_destroy(renderer);
    return RSV_OK;
}

// ---- all of it ----------------------------------------------------------------------------------

static rsv_status measure(const cli_bench_task *bench, const rsv_scene *scene, cJSON *result)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution = NULL;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status == RSV_OK) status = measure_single(solution, bench->repetitions, result);
    if (status == RSV_OK) status = measure_stereo(solution, bench->repetitions, result);
    if (status == RSV_OK) status = measure_steady_state(bench, solution, result);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    rsv_light_destroy(solution);
    return status;
}

bool cli_bench_fps(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_body(bench, body_triangles);
    if (!scene) return false;
    cJSON_AddNumberToObject(result, "triangles", (double)rsv_scene_get_view(scene)->triangle_count);
    rsv_status status = measure(bench, scene, result);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_fps(const cJSON *result)
{
    printf("  %.0f triangles, %s\n", cli_json_number(result, "triangles"),
        cJSON_GetStringValue(cJSON_GetObjectItem(result, "instructions")));
    printf("  1280x720               %.1f ms, %.1f frames/s; the fastest %.1f ms\n",
        1e3 * cli_json_number(result, "frame_s"), cli_json_number(result, "frames_per_second"),
        cli_json_number(result, "best_ms"));
    printf("  bare ray tracing       %.1f ms; frame : tracing %.2f, in processor time %.2f\n",
        1e3 * cli_json_number(result, "tracing_s"), cli_json_number(result, "ratio_to_tracing"),
        cli_json_number(result, "ratio_to_tracing_cpu"));
    printf("  processor time         %.1f ms per frame\n",
        1e3 * cli_json_number(result, "frame_cpu_s"));
    printf("  stages, per thread     camera %.1f ms, paths %.1f ms (%.0f rays), display %.1f ms\n",
        cli_json_number(result, "camera_ms"), cli_json_number(result, "path_ms"),
        cli_json_number(result, "path_rays"), cli_json_number(result, "display_ms"));
    printf("  second eye, 1920x1080  %.2f of the first\n", cli_json_number(result, "second_eye"));
    printf("  %.0f frames          %.0f allocations, memory grew by %.0f bytes\n",
        cli_json_number(result, "steady_frames"), cli_json_number(result, "allocations"),
        cli_json_number(result, "grown_bytes"));
}

bool cli_write_fps_plot(const char *path, const cJSON *scenes)
{
    cli_bars bars = { .title = "milliseconds at 1280x720",
        .series = { "bare ray tracing", "whole frame" },
        .scale = 1e3 };
    const cJSON *scene;
    cJSON_ArrayForEach(scene, scenes)
    {
        cli_bar_group *group = &bars.group[bars.group_count++];
        group->name = cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene"));
        group->value[0] = cli_json_number(scene, "tracing_s");
        group->value[1] = cli_json_number(scene, "frame_s");
    }
    return cli_write_bars(path, &bars);
}

bool cli_write_fps_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "triangles", "frame_s", "frame_cpu_s", "tracing_s",
        "ratio_to_tracing", "ratio_to_tracing_cpu", "frames_per_second", "second_eye", "path_rays",
        "allocations", "grown_bytes" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}
