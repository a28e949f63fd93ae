#include "benchmarks.h"
#include "stats.h"

#include "resolvent/measure.h"
#include "resolvent/solve.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double least(double a, double b) { return a < b ? a : b; }

/// Fastest passes, and the ratios of the passes that ran one after the other.
typedef struct assembly_timing {
    rsv_assembly_cost fastest;
    double *packet_ratio, *single_ratio; ///< [repetitions] rays per second, assembly : tracing
} assembly_timing;

static rsv_status time_assembly(
    const rsv_light *solution, uint32_t repetitions, assembly_timing *timing)
{
    timing->fastest = (rsv_assembly_cost){ 0, INFINITY, INFINITY, INFINITY };
    for (uint32_t i = 0; i < repetitions; i++) {
        rsv_assembly_cost cost;
        rsv_status status = rsv_measure_assembly(solution, &cost);
        if (status != RSV_OK) return status;
        if (cli_interrupted()) return RSV_ERROR_CANCELLED;
        rsv_assembly_cost *fastest = &timing->fastest;
        fastest->rays = cost.rays;
        fastest->assembly_seconds = least(fastest->assembly_seconds, cost.assembly_seconds);
        fastest->tracing_seconds = least(fastest->tracing_seconds, cost.tracing_seconds);
        fastest->single_seconds = least(fastest->single_seconds, cost.single_seconds);
        timing->packet_ratio[i] = cost.tracing_seconds / cost.assembly_seconds;
        timing->single_ratio[i] = cost.single_seconds / cost.assembly_seconds;
    }
    return RSV_OK;
}

static void add_ratio(cJSON *result, const char *name, double *ratio, uint32_t count)
{
    cJSON *object = cJSON_AddObjectToObject(result, name);
    cJSON_AddNumberToObject(object, "median", cli_median(ratio, count));
    cJSON_AddNumberToObject(object, "best", ratio[count - 1]);
}

static void add_timing(cJSON *result, const assembly_timing *timing, uint32_t repetitions)
{
    const rsv_assembly_cost *cost = &timing->fastest;
    double rays = (double)cost->rays;
    cJSON_AddNumberToObject(result, "rays", rays);
    cJSON *rate = cJSON_AddObjectToObject(result, "rays_per_second");
    cJSON_AddNumberToObject(rate, "assembly", rays / cost->assembly_seconds);
    cJSON_AddNumberToObject(rate, "packets", rays / cost->tracing_seconds);
    cJSON_AddNumberToObject(rate, "single", rays / cost->single_seconds);
    add_ratio(result, "ratio_to_packets", timing->packet_ratio, repetitions);
    add_ratio(result, "ratio_to_single", timing->single_ratio, repetitions);
}

static rsv_status measure(const cli_bench_task *bench, const rsv_scene *scene, rsv_quality quality,
    assembly_timing *timing, cJSON *result)
{
    rsv_solve_desc desc = cli_bench_solve_desc(bench, quality);
    desc.direct_level = false;
    rsv_light *solution = NULL;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status != RSV_OK) return status;
    const rsv_solve_report *report = rsv_light_report(solution);
    cJSON_AddStringToObject(result, "quality", cli_quality_names[quality]);
    cJSON_AddNumberToObject(result, "elements", (double)report->elements);
    status = time_assembly(solution, bench->repetitions, timing);
    rsv_light_destroy(solution);
    if (status == RSV_OK) add_timing(result, timing, bench->repetitions);
    return status;
}

bool cli_bench_assemble(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_scene(bench->session, bench->scene, NULL);
    if (!scene) return false;
    rsv_status status = RSV_ERROR_MEMORY;
    assembly_timing timing = { .packet_ratio = calloc(bench->repetitions, sizeof(double)),
        .single_ratio = calloc(bench->repetitions, sizeof(double)) };
    cJSON *qualities = cJSON_AddArrayToObject(result, "qualities");
    if (timing.packet_ratio && timing.single_ratio) {
        status = RSV_OK;
        bool both = bench->quality == BENCH_DRAFT_AND_MEDIUM;
        rsv_quality first = both ? RSV_QUALITY_DRAFT : (rsv_quality)bench->quality;
        rsv_quality last = both ? RSV_QUALITY_MEDIUM : first;
        for (rsv_quality q = first; q <= last && !status; q++) {
            cJSON *object = cJSON_CreateObject();
            cJSON_AddItemToArray(qualities, object);
            status = measure(bench, scene, q, &timing, object);
        }
    }
    free(timing.packet_ratio);
    free(timing.single_ratio);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

static void print_ratio(const cJSON *ratio, const char *against)
{
    printf("  assembly : %-26s %.3f median, %.3f best\n", against, cli_json_number(ratio, "median"),
        cli_json_number(ratio, "best"));
}

void cli_print_assemble(const cJSON *result)
{
    const cJSON *quality;
    cJSON_ArrayForEach(quality, cJSON_GetObjectItem(result, "qualities"))
    {
        const cJSON *rate = cJSON_GetObjectItem(quality, "rays_per_second");
        printf("  %s: %.0f elements, %.4g M rays\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(quality, "quality")),
            cli_json_number(quality, "elements"), 1e-6 * cli_json_number(quality, "rays"));
        const cJSON *member;
        cJSON_ArrayForEach(member, rate)
        {
            printf("  %-20s %.4g M rays/s\n", member->string, 1e-6 * member->valuedouble);
        }
        print_ratio(cJSON_GetObjectItem(quality, "ratio_to_packets"), "same packets, traced only");
        print_ratio(cJSON_GetObjectItem(quality, "ratio_to_single"), "same rays one by one");
    }
}
