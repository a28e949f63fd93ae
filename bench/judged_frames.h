/// How far the frames of a flight are from converged pictures of the same views.
#ifndef CLI_JUDGED_FRAMES_H
#define CLI_JUDGED_FRAMES_H

#include "benchmarks.h"

#include "resolvent/solve.h"

/// Flies, rests, cuts, and compares the frames with two pictures of mode final, by means of 2x2 pixels. Results:
/// "moving_mse", "moving_mean" (ratio), "resting_..." after 64 frames at rest, "cut_..." of the first frame after a
/// cut, and "flicker" (RMS of the difference of neighbouring frames at rest over the mean: the median of the first 16;
/// "flicker_first": of the first). If there is a folder for strips, also the file "strip".
/// @param name of files: of references and strips
rsv_status cli_judge_frames(
    const cli_bench_task *bench, const rsv_light *light, const char *name, struct cJSON *result);

/// Dims the first source while the camera rests: "switch_ms" from the change to the first frame that shows it,
/// "switch_done_ms" until the light has converged, "remnant": by how much the mean of the third frame differs from that
/// of frames that began after it. Nothing where the scene has no source. The light stays changed.
rsv_status cli_measure_switch(const cli_bench_task *bench, rsv_light *light, struct cJSON *result);

#endif
