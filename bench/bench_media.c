/// Fog: error over time of pictures as in bench quality, frames, and a light that changes.
#include "flown_frames.h"
#include "judged_frames.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>

/// Frames of 1280x720 of a solution at draft.
static cli_bench_task task_of_frames(const cli_bench_task *bench)
{
    cli_bench_task frames = *bench;
    frames.frame_size = (cli_size){ 1280, 720 };
    if (bench->size < 64) frames.frame_size = (cli_size){ 64, 36 };
    frames.quality = RSV_QUALITY_DRAFT;
    return frames;
}

static bool measure_frames(const cli_bench_task *bench, cJSON *result)
{
    cli_subject subject;
    const cli_bench_task task = task_of_frames(bench);
    if (!cli_open_solved(&task, &subject, result)) return false;
    rsv_status status = cli_fly(&task, subject.solution, result);
    if (status == RSV_OK) status = cli_measure_switch(&task, subject.solution, result);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    cli_close_subject(&subject);
    return status == RSV_OK;
}

bool cli_bench_media(const cli_bench_task *bench, cJSON *result)
{
    return cli_bench_quality(bench, result) &&
           measure_frames(bench, cJSON_AddObjectToObject(result, "frames"));
}

void cli_print_media(const cJSON *result)
{
    const cJSON *frames = cJSON_GetObjectItem(result, "frames");
    cli_print_quality(result);
    printf("  frames, %s: %.1f ms, CPU %.1f ms; solved in %.2f s\n",
        cJSON_GetStringValue(cJSON_GetObjectItem(frames, "size")),
        cli_json_number(frames, "median_ms"), cli_json_number(frames, "cpu_ms"),
        cli_json_number(frames, "solve_s"));
    double shown = cli_json_number(frames, "switch_ms");
    if (isfinite(shown))
        printf("  a light dimmed: shown after %.1f ms, converged after %.1f ms\n", shown,
            cli_json_number(frames, "switch_done_ms"));
}
