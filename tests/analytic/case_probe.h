/// Readings of a case: the values at its probes, through the library's probes and pictures.
#ifndef CASE_PROBE_H
#define CASE_PROBE_H

#include "case_scene.h"

enum {
    CASE_MAX_VARIANTS = 12,
    CASE_OPINIONS = 5 ///< second ones, beside opinion 0
};

/// One variant of the scene, built and, in mode operator, solved.
typedef struct case_solution {
    case_variant variant;
    uint32_t opinion;
    rsv_scene *scene;
    rsv_light *solution;
} case_solution;

/// Everything that the readings of one case share.
typedef struct case_bench {
    rsv_context *context;
    rsv_probe_mode mode; ///< lookup: only light from mirrors and glass to plates
    uint32_t opinion;    ///< of solutions and probes with random numbers of their own
    case_scene scene;
    const cJSON *expected; ///< all quantities of the case: some are divided by others
    case_solution solution[CASE_MAX_VARIANTS * (1 + CASE_OPINIONS)]; ///< made when first wanted
    int solution_count;
} case_bench;

typedef struct case_reading {
    double value, standard_error;
} case_reading;

/// Takes note of an expected quantity before any reading: radiances need a camera in the scene.
void case_bench_announce(case_bench *bench, const cJSON *expected);

/// Reads one expected quantity, an object with `name` and `probe`. *known is false, and nothing is
/// read, if this harness has no probe for it.
rsv_status case_bench_read(
    case_bench *bench, const cJSON *expected, case_reading *reading, bool *known);

/// Frees all that the readings have allocated.
void case_bench_close(case_bench *bench);

#endif
