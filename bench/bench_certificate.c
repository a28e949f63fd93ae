#include "benchmarks.h"

#include "resolvent/certify.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Points and paths of the truth, of each of its two readings.
enum { truth_points = 2000, default_paths = 2048 };

enum { seed_count = 2 };

typedef struct grade {
    const char *name;
    rsv_quality quality;
    uint32_t elements, rays; ///< 0 = as the quality says
} grade;

/// From solutions too coarse for use to the usual ones.
static const grade grades[] = {
    { "rough", RSV_QUALITY_DRAFT, 300, 64 },
    { "draft", RSV_QUALITY_DRAFT, 0, 0 },
    { "fair", RSV_QUALITY_DRAFT, 6000, 1024 },
    { "medium", RSV_QUALITY_MEDIUM, 0, 0 },
};
enum { grade_count = sizeof grades / sizeof grades[0] };

static rsv_solve_desc describe_solve(const grade *g, uint32_t seed)
{
    rsv_solve_desc desc = rsv_default_solve_desc(g->quality);
    if (g->elements) desc.element_target = g->elements;
    if (g->rays) desc.rays_per_element = g->rays;
    desc.seed = seed;
    return desc;
}

static cJSON *describe_case(const grade *g, uint32_t seed, const rsv_light *solution,
    const rsv_certificate *c, double error, const double interval[2])
{
    cJSON *object = cJSON_CreateObject();
    double solve = rsv_light_report(solution)->time_assemble;
    cJSON_AddStringToObject(object, "quality", g->name);
    cJSON_AddNumberToObject(object, "seed", seed);
    cJSON_AddNumberToObject(object, "elements", (double)rsv_light_report(solution)->elements);
    cJSON_AddNumberToObject(object, "irradiance_rms", c->irradiance_rms);
    cJSON_AddNumberToObject(object, "true_error", error);
    cJSON_AddNumberToObject(object, "true_error_low", interval[0]);
    cJSON_AddNumberToObject(object, "true_error_high", interval[1]);
    cJSON_AddNumberToObject(object, "residual_rms", c->residual_rms);
    cJSON_AddNumberToObject(object, "error_estimate", c->error_estimate_rms);
    cJSON_AddNumberToObject(object, "error_bound", c->error_bound_rms);
    cJSON_AddNumberToObject(object, "certify_time_ratio", c->seconds / solve);
    return object;
}

/// Solves, certifies and compares. The first solution of a scene decides where the reference is computed.
static rsv_status measure_case(const cli_bench_task *bench, const rsv_scene *scene, const grade *g,
    uint32_t seed, rsv_truth **truth, cJSON *cases)
{
    double error, interval[2];
    rsv_certificate certificate;
    rsv_certify_desc certify = rsv_default_certify_desc();
    rsv_solve_desc desc = describe_solve(g, seed);
    rsv_light *solution = NULL;
    certify.seed = seed;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status == RSV_OK) status = rsv_certify(solution, &certify, &certificate);
    if (status == RSV_OK && !*truth)
        status = rsv_truth_create(solution, truth_points, bench->paths, 1, truth);
    if (status == RSV_OK) status = rsv_truth_error(*truth, solution, &error, interval);
    if (status == RSV_OK)
        cJSON_AddItemToArray(
            cases, describe_case(g, seed, solution, &certificate, error, interval));
    rsv_light_destroy(solution);
    return status == RSV_OK && cli_interrupted() ? RSV_ERROR_CANCELLED : status;
}

bool cli_bench_certificate(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    rsv_truth *truth = NULL;
    rsv_status status = RSV_OK;
    cJSON *cases = cJSON_AddArrayToObject(result, "cases");
    cli_bench_task task = *bench;
    if (task.paths == 0) task.paths = default_paths;
    for (uint32_t i = 0; i < grade_count * seed_count && status == RSV_OK; i++)
        status =
            measure_case(&task, scene, &grades[i / seed_count], 1 + i % seed_count, &truth, cases);
    rsv_truth_destroy(truth);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_certificate(const cJSON *result)
{
    const cJSON *one;
    printf("  %-8s %4s %9s %22s %10s %10s %8s %8s\n", "quality", "seed", "elements",
        "true error (95 %)", "estimate", "bound", "est/true", "bound/true");
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "cases"))
    {
        double percent = 100 / cli_json_number(one, "irradiance_rms");
        double error = cli_json_number(one, "true_error");
        printf("  %-8s %4.0f %9.0f %6.2f %% (%5.2f..%5.2f) %8.2f %% %8.2f %% %8.3f %8.2f\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(one, "quality")), cli_json_number(one, "seed"),
            cli_json_number(one, "elements"), percent * error,
            percent * cli_json_number(one, "true_error_low"),
            percent * cli_json_number(one, "true_error_high"),
            percent * cli_json_number(one, "error_estimate"),
            percent * cli_json_number(one, "error_bound"),
            cli_json_number(one, "error_estimate") / error,
            cli_json_number(one, "error_bound") / error);
    }
}

/// Statistics of all cases and scenes against the claims of certificates.
typedef struct summary {
    size_t count, held;  ///< cases, and those whose bound holds
    double *bound, *off; ///< [count] bound over true error; |estimate / true - 1|
} summary;

static void add_case(summary *s, const cJSON *one)
{
    double error = cli_json_number(one, "true_error"), bound = cli_json_number(one, "error_bound");
    double *grown = realloc(s->bound, (s->count + 1) * sizeof *grown);
    if (grown) s->bound = grown;
    double *off = realloc(s->off, (s->count + 1) * sizeof *off);
    if (off) s->off = off;
    if (!grown || !off) return;
    s->bound[s->count] = bound / error;
    s->off[s->count++] = fabs(cli_json_number(one, "error_estimate") / error - 1);
    s->held += error <= bound;
}

void cli_print_certificate_summary(const cJSON *scenes)
{
    summary s = { 0 };
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases")) add_case(&s, one);
    }
    if (s.count > 0)
        printf("bound holds in %zu of %zu cases; bound / true error %.2f (median); estimate off by "
               "%.1f %% (median)\n",
            s.held, s.count, cli_median(s.bound, s.count), 100 * cli_median(s.off, s.count));
    free(s.bound);
    free(s.off);
}
