/// Frames per second: whole frames compared with bare ray tracing, stereo, and a search for leaks.
#include "bars.h"
#include "flown_frames.h"

#include "resolvent/frame.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { steady_frames = 10000 };

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

static void add_median(cJSON *result, const char *name, double *values, uint32_t count)
{
    cJSON_AddNumberToObject(result, name, cli_median(values, count));
}

// ---- two eyes -----------------------------------------------------------------------------------

/// Cost of the second eye as a share of a frame with one.
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

bool cli_bench_fps(const cli_bench_task *bench, cJSON *result)
{
    cli_subject subject;
    if (!cli_open_solved(bench, &subject, result)) return false;
    rsv_status status = cli_fly(bench, subject.solution, result);
    if (bench->repetitions) {
        if (status == RSV_OK) status = measure_stereo(subject.solution, bench->repetitions, result);
        if (status == RSV_OK) status = measure_steady_state(bench, subject.solution, result);
    }
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    cli_close_subject(&subject);
    return status == RSV_OK;
}

static void print_long_run(const cJSON *result)
{
    printf("  second eye, 1920x1080  %.2f of the first\n", cli_json_number(result, "second_eye"));
    printf("  %.0f frames          %.0f allocations, memory grew by %.0f bytes\n",
        cli_json_number(result, "steady_frames"), cli_json_number(result, "allocations"),
        cli_json_number(result, "grown_bytes"));
}

void cli_print_fps(const cJSON *result)
{
    const cJSON *stages = cJSON_GetObjectItem(result, "stages_ms");
    printf("  %.0f triangles, %.0f elements, %s\n", cli_json_number(result, "triangles"),
        cli_json_number(result, "elements"),
        cJSON_GetStringValue(cJSON_GetObjectItem(result, "instructions")));
    printf("  %-22s %.1f ms, %.1f frames/s; the worst of %.0f %.1f ms, the first %.1f ms\n",
        cJSON_GetStringValue(cJSON_GetObjectItem(result, "size")),
        cli_json_number(result, "median_ms"), cli_json_number(result, "frames_per_second"),
        cli_json_number(result, "frames"), cli_json_number(result, "worst_ms"),
        cli_json_number(result, "first_ms"));
    printf("  bare ray tracing       %.1f ms; frame : tracing %.2f, in processor time %.2f\n",
        cli_json_number(result, "bare_ms"), cli_json_number(result, "ratio"),
        cli_json_number(result, "ratio_cpu"));
    printf("  processor time         %.1f ms per frame\n", cli_json_number(result, "cpu_ms"));
    printf("  stages, per thread     camera %.1f ms, paths %.1f ms (%.0f rays), "
           "gloss %.1f ms (%.0f rays), display %.1f ms\n",
        cli_json_number(stages, "camera"), cli_json_number(stages, "paths"),
        cli_json_number(result, "path_rays"), cli_json_number(stages, "gloss"),
        cli_json_number(result, "gloss_rays"), cli_json_number(stages, "display"));
    if (cJSON_HasObjectItem(result, "second_eye")) print_long_run(result);
}

bool cli_write_fps_plot(const char *path, const cJSON *scenes)
{
    cli_bars bars = { .title = "milliseconds per frame",
        .series = { "bare ray tracing", "whole frame" },
        .scale = 1 };
    const cJSON *scene;
    cJSON_ArrayForEach(scene, scenes)
    {
        cli_bar_group *group = &bars.group[bars.group_count++];
        group->name = cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene"));
        group->value[0] = cli_json_number(scene, "bare_ms");
        group->value[1] = cli_json_number(scene, "median_ms");
    }
    return cli_write_bars(path, &bars);
}

bool cli_write_fps_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "triangles", "median_ms", "worst_ms", "bare_ms", "ratio",
        "cpu_ms", "ratio_cpu", "frames_per_second", "path_rays" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}
