#include "benchmarks.h"
#include "session.h"

#include <cJSON.h>
#include <resolvent_rt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { RECEIVERS = 100000, LIGHTS = 4, PASSES = 21, PADDING = 16 };

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/// Medians of passes that alternate with copies of the same data: memory sets the pace.
static void time_passes(const rsv_rt_basis *basis, float *value, float *out, cJSON *result)
{
    const float scale[3 * LIGHTS] = { 1, 0.9f, 0.8f, 0, 2, 0, 0.5f, 0.5f, 0.5f, 1, 3, 0.1f };
    size_t bytes = (size_t)LIGHTS * RECEIVERS * 3 * sizeof *value;
    double relight[PASSES], copy[PASSES];
    for (int pass = 0; pass < PASSES; pass++) {
        double start = seconds();
        rsv_rt_relight(basis, scale, LIGHTS, 0, RECEIVERS, out);
        double end = seconds();
        memmove(value + PADDING, value, bytes);
        copy[pass] = seconds() - end;
        relight[pass] = end - start;
    }
    cJSON_AddNumberToObject(result, "ms", 1e3 * cli_median(relight, PASSES));
    cJSON_AddNumberToObject(result, "ms_copy", 1e3 * cli_median(copy, PASSES));
}

bool cli_bench_relight(const cli_bench_task *bench, cJSON *result)
{
    size_t floats = (size_t)LIGHTS * RECEIVERS * 3;
    float *value = malloc((floats + PADDING) * sizeof *value);
    float *out = malloc((size_t)RECEIVERS * 3 * sizeof *out);
    const rsv_rt_basis basis = { LIGHTS, RECEIVERS, 1, value };
    if (value && out) {
        for (size_t k = 0; k < floats + PADDING; k++)
            value[k] = (float)(k % 251) / 251;
        time_passes(&basis, value, out, result);
    } else {
        cli_report_failure(bench->session, RSV_ERROR_MEMORY);
    }
    free(value);
    free(out);
    return cJSON_HasObjectItem(result, "ms");
}

void cli_print_relight(const cJSON *result)
{
    printf("  one thread           %.3g ms\n", cli_json_number(result, "ms"));
    printf("  copying the basis    %.3g ms\n", cli_json_number(result, "ms_copy"));
}
