/// Frames on a device, moving from one to the next so that none adds up.
#include "bench_gpu.h"
#include "device.h"

#include "resolvent/frame.h"

#include <cJSON.h>
#include <stdlib.h>

/// Metres that the camera steps aside.
static const float step = 0.001f;

static rsv_status time_frames(
    rsv_frame_renderer *renderer, const rsv_scene *scene, uint32_t count, double *seconds)
{
    rsv_frame_view view = { .camera = { rsv_scene_get_view(scene)->camera[0] } };
    rsv_frame_stats stats;
    rsv_status status = rsv_frame_render(renderer, &view, &stats); // the first one brings the light
    for (uint32_t k = 0; k < count && status == RSV_OK && !cli_interrupted(); k++) {
        view.camera[0].position.x += k % 2 ? -step : step;
        status = rsv_frame_render(renderer, &view, &stats);
        seconds[k] = 1e-3 * stats.total_ms;
    }
    return status == RSV_OK && cli_interrupted() ? RSV_ERROR_CANCELLED : status;
}

rsv_status cli_measure_gpu_frames(
    const cli_bench_task *bench, const rsv_light *solution, cJSON *result)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    rsv_frame_renderer *renderer = NULL;
    bool emulated = cli_device_is_emulated();
    double *seconds = calloc(bench->repetitions, sizeof *seconds);
    desc.width = emulated ? 192 : 1920;
    desc.height = emulated ? 108 : 1080;
    rsv_status status = seconds ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = rsv_frame_renderer_create(solution, &desc, &renderer);
    if (status == RSV_OK)
        status = time_frames(renderer, rsv_light_scene(solution), bench->repetitions, seconds);
    if (status == RSV_OK) {
        cJSON_AddNumberToObject(result, "frame_width", desc.width);
        cJSON_AddNumberToObject(result, "frame_height", desc.height);
        cJSON_AddNumberToObject(result, "frame_seconds", cli_median(seconds, bench->repetitions));
    }
    rsv_frame_renderer_destroy(renderer);
    free(seconds);
    return status;
}
