#include "benchmarks.h"
#include "stats.h"

#include "resolvent/measure.h"
#include "resolvent/solve.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Relative residual that all solvers must reach.
static const double goal = 1e-5;

/// A solver's history: one row per residual.
typedef struct history {
    double started;
    double *rows; ///< [count][3] applications, seconds, residual
    size_t count, capacity;
} history;

static void remember(void *user, double applications, double residual)
{
    history *h = user;
    if (h->count == h->capacity) {
        size_t capacity = 2 * h->capacity + 64;
        double *grown = realloc(h->rows, 3 * capacity * sizeof *grown);
        if (!grown) return;
        h->rows = grown;
        h->capacity = capacity;
    }
    double *row = h->rows + 3 * h->count++;
    row[0] = applications;
    row[1] = cli_seconds() - h->started;
    row[2] = residual;
}

/// Times the fastest of the repetitions. @return what they cost
static rsv_status time_solver(const rsv_light *solution, rsv_solver solver, uint32_t repetitions,
    history *fastest, rsv_solver_cost *cost)
{
    rsv_status status = RSV_OK;
    for (uint32_t i = 0; i < repetitions && status == RSV_OK; i++) {
        history h = { .started = cli_seconds() };
        rsv_solver_cost now;
        status = rsv_measure_solver(solution, solver, goal, remember, &h, &now);
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        bool faster = status == RSV_OK && (i == 0 || now.seconds < cost->seconds);
        if (faster) *cost = now;
        free(faster ? fastest->rows : h.rows);
        if (faster) *fastest = h;
    }
    return status;
}

static cJSON *describe(rsv_solver solver, const rsv_solver_cost *cost, const history *h)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "name", rsv_solver_name(solver));
    cJSON_AddStringToObject(object, "solver", rsv_solver_name(cost->solver));
    cJSON_AddBoolToObject(object, "converged", cost->stop_reason == RSV_STOP_CONVERGED);
    cJSON_AddNumberToObject(object, "applications", cost->applications);
    cJSON_AddNumberToObject(object, "seconds", cost->seconds);
    cJSON_AddNumberToObject(object, "residual", cost->residual);
    cJSON *rows = cJSON_AddArrayToObject(object, "history");
    for (size_t i = 0; i < h->count; i++)
        cJSON_AddItemToArray(rows, cJSON_CreateDoubleArray(h->rows + 3 * i, 3));
    return object;
}

/// Applications are short: this many pairs of one application and the bare loop are timed.
enum { APPLICATION_PAIRS = 31 };

static rsv_status measure_application(const rsv_light *solution, cJSON *result)
{
    double ratio[APPLICATION_PAIRS];
    rsv_status status = rsv_measure_application(solution, APPLICATION_PAIRS, ratio);
    if (status == RSV_OK)
        cJSON_AddNumberToObject(result, "bare_gather_ratio", cli_median(ratio, APPLICATION_PAIRS));
    return status;
}

static rsv_status measure_all(const cli_bench_task *bench, const rsv_light *solution, cJSON *result)
{
    const rsv_solve_report *report = rsv_light_report(solution);
    cJSON_AddNumberToObject(result, "elements", (double)report->elements);
    cJSON_AddNumberToObject(result, "entries", (double)report->entries);
    cJSON_AddNumberToObject(result, "norm_inf", report->norm_inf);
    cJSON_AddNumberToObject(result, "spectral_radius", report->spectral_radius);
    cJSON *solvers = cJSON_AddArrayToObject(result, "solvers");
    rsv_status status = measure_application(solution, result);
    for (rsv_solver solver = 0; rsv_solver_name(solver) && status == RSV_OK; solver++) {
        if (solver == RSV_SOLVER_PETSC) continue; // needs a team of processes
        history h = { 0 };
        rsv_solver_cost cost = { 0 };
        status = time_solver(solution, solver, bench->repetitions, &h, &cost);
        if (status == RSV_OK) cJSON_AddItemToArray(solvers, describe(solver, &cost, &h));
        free(h.rows);
    }
    return status;
}

bool cli_bench_solvers(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    rsv_solve_desc desc = cli_bench_solve_desc(bench, bench->quality);
    desc.direct_level = false;
    rsv_light *solution = NULL;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status == RSV_OK) status = measure_all(bench, solution, result);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

/// The member of `solvers` that is called `name`.
static const cJSON *find_solver(const cJSON *result, const char *name)
{
    const cJSON *solver;
    cJSON_ArrayForEach(solver, cJSON_GetObjectItem(result, "solvers"))
    {
        if (strcmp(cJSON_GetStringValue(cJSON_GetObjectItem(solver, "name")), name) == 0)
            return solver;
    }
    return NULL;
}

void cli_print_solvers(const cJSON *result)
{
    const cJSON *solver, *series = find_solver(result, "neumann");
    printf("  %.0f elements, %.3g M entries, norm %.4f, spectral radius %.4f\n",
        cli_json_number(result, "elements"), 1e-6 * cli_json_number(result, "entries"),
        cli_json_number(result, "norm_inf"), cli_json_number(result, "spectral_radius"));
    printf("  bare gather loop : application  %.3f median\n",
        cli_json_number(result, "bare_gather_ratio"));
    printf("  %-14s %-14s %12s %10s %10s %14s\n", "asked for", "solver", "applications", "time ms",
        "residual", "time:neumann");
    cJSON_ArrayForEach(solver, cJSON_GetObjectItem(result, "solvers"))
    {
        double seconds = cli_json_number(solver, "seconds");
        printf("  %-14s %-14s %12.1f %10.3g %10.2g %14.3f%s\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(solver, "name")),
            cJSON_GetStringValue(cJSON_GetObjectItem(solver, "solver")),
            cli_json_number(solver, "applications"), 1e3 * seconds,
            cli_json_number(solver, "residual"), seconds / cli_json_number(series, "seconds"),
            cJSON_IsTrue(cJSON_GetObjectItem(solver, "converged")) ? "" : "  not converged");
    }
}
