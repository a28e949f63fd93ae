/// Frames in real rooms: time by stage, error while moving and at rest, flicker, and a light that is switched.
#include "bars.h"
#include "flown_frames.h"
#include "judged_frames.h"
#include "room_files.h"

#include <cJSON.h>
#include <limits.h>
#include <stdio.h>
#include <unistd.h>

/// Files of one scene of the benchmark.
typedef struct room {
    cli_room_files files;
    char solved[PATH_MAX];
} room;

/// False after a message.
static bool locate(const cli_bench_task *bench, room *r)
{
    if (!cli_find_room(bench, "rooms", &r->files)) return false;
    r->solved[0] = '\0';
    if (bench->cache)
        snprintf(r->solved, sizeof r->solved, "%s/%s-%s.safetensors", bench->cache, r->files.name,
            cli_quality_names[bench->quality]);
    return true;
}

/// From the cache where it is there, else solved and left there.
static bool open_room(
    const cli_bench_task *bench, const room *r, cli_subject *subject, cJSON *result)
{
    cli_bench_task task = *bench;
    bool is_kept = r->solved[0] && access(r->solved, R_OK) == 0;
    task.scene = is_kept ? r->solved : r->files.scene;
    task.environment.path = is_kept || !r->files.environment[0] ? NULL : r->files.environment;
    if (!cli_open_solved(&task, subject, result)) return false;
    if (is_kept || !r->solved[0] || rsv_is_operator_file(r->files.scene)) return true;
    rsv_status status = rsv_light_save(subject->solution, r->files.scene, r->solved);
    if (status == RSV_OK) return true;
    cli_report_failure(bench->session, status);
    cli_close_subject(subject);
    return false;
}

bool cli_bench_rooms(const cli_bench_task *bench, cJSON *result)
{
    room r;
    cli_subject subject;
    if (!locate(bench, &r)) return false;
    if (cli_room_is_missing(&r.files, result)) return true;
    if (!open_room(bench, &r, &subject, result)) return false;
    rsv_status status = cli_fly(bench, subject.solution, result);
    if (status == RSV_OK) status = cli_judge_frames(bench, subject.solution, r.files.name, result);
    if (status == RSV_OK) status = cli_measure_switch(bench, subject.solution, result);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    cli_close_subject(&subject);
    return status == RSV_OK;
}

// ---- output -------------------------------------------------------------------------------------

void cli_print_rooms(const cJSON *result)
{
    const cJSON *skipped = cJSON_GetObjectItem(result, "skipped");
    const cJSON *stages = cJSON_GetObjectItem(result, "stages_ms");
    if (skipped) {
        printf("  skipped: %s\n", cJSON_GetStringValue(skipped));
        return;
    }
    printf("  frame   %.1f ms (worst %.1f, bare tracing %.1f), %.0f ms of processors; camera %.1f, "
           "paths %.1f, gloss %.1f, display %.1f ms\n",
        cli_json_number(result, "median_ms"), cli_json_number(result, "worst_ms"),
        cli_json_number(result, "bare_ms"), cli_json_number(result, "cpu_ms"),
        cli_json_number(stages, "camera"), cli_json_number(stages, "paths"),
        cli_json_number(stages, "gloss"), cli_json_number(stages, "display"));
    printf("  error   moving %.2g (mean %.4f), after a cut %.2g, at rest %.2g (mean %.4f)\n",
        cli_json_number(result, "moving_mse"), cli_json_number(result, "moving_mean"),
        cli_json_number(result, "cut_mse"), cli_json_number(result, "resting_mse"),
        cli_json_number(result, "resting_mean"));
    printf("  flicker %.2f %% (first %.2f %%); a light switched: %.0f ms, converged after %.0f ms, "
           "remnant %.2f %%\n",
        100 * cli_json_number(result, "flicker"), 100 * cli_json_number(result, "flicker_first"),
        cli_json_number(result, "switch_ms"), cli_json_number(result, "switch_done_ms"),
        100 * cli_json_number(result, "remnant"));
}

/// A table in Markdown, for docs/benchmarks.md.
void cli_print_rooms_summary(const cJSON *scenes)
{
    const cJSON *s;
    puts("\n| scene | frame, ms | worst | bare | frame : bare, processor | camera | paths | "
         "gloss | display | moving: "
         "MSE | mean | after a cut | at rest: MSE | mean | flicker | switch, ms | remnant |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    cJSON_ArrayForEach(s, scenes)
    {
        const cJSON *stages = cJSON_GetObjectItem(s, "stages_ms");
        if (!stages) continue;
        printf("| %s | %.1f | %.1f | %.1f | %.2f | %.1f | %.1f | %.1f | %.1f | %.2g | %.4f | %.2g "
               "| %.2g | "
               "%.4f | %.2f %% | %.0f | %.2f %% |\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(s, "scene")), cli_json_number(s, "median_ms"),
            cli_json_number(s, "worst_ms"), cli_json_number(s, "bare_ms"),
            cli_json_number(s, "ratio_cpu"), cli_json_number(stages, "camera"),
            cli_json_number(stages, "paths"), cli_json_number(stages, "gloss"),
            cli_json_number(stages, "display"), cli_json_number(s, "moving_mse"),
            cli_json_number(s, "moving_mean"), cli_json_number(s, "cut_mse"),
            cli_json_number(s, "resting_mse"), cli_json_number(s, "resting_mean"),
            100 * cli_json_number(s, "flicker"), cli_json_number(s, "switch_ms"),
            100 * cli_json_number(s, "remnant"));
    }
}

bool cli_write_rooms_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "triangles", "elements", "median_ms", "worst_ms",
        "bare_ms", "ratio", "cpu_ms", "ratio_cpu", "moving_mse", "moving_mean", "cut_mse",
        "cut_mean", "resting_mse", "resting_mean", "flicker", "flicker_first", "switch_ms",
        "switch_done_ms", "remnant" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}

bool cli_write_rooms_plot(const char *path, const cJSON *scenes)
{
    cli_bars bars = { .title = "processor milliseconds per frame",
        .series = { "bare ray tracing", "whole frame" },
        .scale = 1 };
    const cJSON *scene;
    cJSON_ArrayForEach(scene, scenes)
    {
        if (!cJSON_HasObjectItem(scene, "cpu_ms") || bars.group_count == cli_max_groups) continue;
        cli_bar_group *group = &bars.group[bars.group_count++];
        group->name = cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene"));
        double ratio = cli_json_number(scene, "ratio_cpu");
        group->value[0] = ratio > 0 ? cli_json_number(scene, "cpu_ms") / ratio : 0;
        group->value[1] = cli_json_number(scene, "cpu_ms");
    }
    return cli_write_bars(path, &bars);
}
