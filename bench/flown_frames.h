/// Frames of a flight through a solved scene, compared with bare ray tracing of the same camera rays.
#ifndef CLI_FLOWN_FRAMES_H
#define CLI_FLOWN_FRAMES_H

#include "benchmarks.h"
#include "subject.h"

#include "resolvent/solve.h"

/// Frames of one flight at most.
#define CLI_MOST_FLOWN 10000

/// Opens the scene or operator file of a task, solves it if it is not, and says so in the result: "triangles",
/// "elements", "solve_s", "load_s". False after a message.
bool cli_open_solved(const cli_bench_task *bench, cli_subject *subject, struct cJSON *result);

/// Flies and measures, all as medians: "median_ms", "worst_ms", "bare_ms", "ratio" (of neighbouring frames), "first_ms"
/// (not part of the others), "cpu_ms" and "ratio_cpu" (processor time, which other load on the machine lengthens less;
/// the ratio of all frames), and "stages_ms". The task gives the size, the treatment of gloss, and the number of
/// frames: 0 = as many as fit into a few seconds.
rsv_status cli_fly(const cli_bench_task *bench, const rsv_light *light, struct cJSON *result);

/// Seconds of all threads so far.
double cli_processor_seconds(void);

#endif
