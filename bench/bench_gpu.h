/// Parts of `resolvent bench gpu`.
#ifndef CLI_BENCH_GPU_H
#define CLI_BENCH_GPU_H

#include "benchmarks.h"

#include "resolvent/solve.h"

/// Adds a description of the device to a result.
void cli_describe_device(struct cJSON *result);

/// 1920x1080 frames of the scene's first camera, until they lie in the device's memory; a tenth of that a side on the
/// emulated device.
rsv_status cli_measure_gpu_frames(
    const cli_bench_task *bench, const rsv_light *solution, struct cJSON *result);

#endif
