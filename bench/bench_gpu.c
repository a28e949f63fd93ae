#include "bench_gpu.h"
#include "device.h"
#include "resolvent/measure.h"
#include "stats.h"

#include <cJSON.h>
#include <stdio.h>
#include <stdlib.h>

// Figures that one should reach are in the table's last column; ratios are of things measured in this run.

enum { RECEIVERS = 1000000, LIGHTS = 8, MOST_REPETITIONS = 1000 };

/// Residual that solvers are timed down to, as in bench solvers.
static const double goal = 1e-5;

void cli_describe_device(cJSON *result)
{
    const rsv_device_info *info = rsv_device_get_info(cli_device());
    cJSON *device = cJSON_AddObjectToObject(result, "device");
    cJSON_AddStringToObject(device, "name", info->name);
    cJSON_AddStringToObject(device, "capability", info->capability);
    cJSON_AddStringToObject(device, "driver", info->driver);
    cJSON_AddStringToObject(device, "runtime", info->runtime);
    cJSON_AddNumberToObject(device, "memory_bytes", (double)info->memory_bytes);
    cJSON_AddNumberToObject(device, "cache_bytes", (double)info->cache_bytes);
    cJSON_AddNumberToObject(device, "processors", info->processors);
}

/// An application of the operator compared with copies of memory.
static rsv_status measure_operator(
    const cli_bench_task *bench, const rsv_light *solution, cJSON *result)
{
    const rsv_solve_report *report = rsv_light_report(solution);
    double rate[MOST_REPETITIONS], seconds[MOST_REPETITIONS];
    size_t bytes;
    rsv_status status = rsv_measure_device(solution, bench->repetitions, rate, seconds, &bytes);
    if (status != RSV_OK) return status;
    double copied = cli_median(rate, bench->repetitions);
    double applied = cli_median(seconds, bench->repetitions);
    cJSON_AddNumberToObject(result, "elements", (double)report->elements);
    cJSON_AddNumberToObject(result, "entries", (double)report->entries);
    cJSON_AddNumberToObject(result, "copy_bytes_per_second", copied);
    cJSON_AddNumberToObject(result, "application_seconds", applied);
    cJSON_AddNumberToObject(result, "application_bytes", (double)bytes);
    cJSON_AddNumberToObject(result, "application_over_copy", (double)bytes / applied / copied);
    return RSV_OK;
}

/// One solver: everything included, from the operator on the host to the solution there.
static rsv_status measure_solver(
    const cli_bench_task *bench, const rsv_light *solution, rsv_solver solver, cJSON *solvers)
{
    double seconds[MOST_REPETITIONS];
    rsv_solver_cost cost = { 0 };
    for (uint32_t k = 0; k < bench->repetitions; k++) {
        rsv_status status = rsv_measure_solver(solution, solver, goal, NULL, NULL, &cost);
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        if (status != RSV_OK) return status;
        seconds[k] = cost.seconds;
    }
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "name", rsv_solver_name(solver));
    cJSON_AddNumberToObject(object, "seconds", cli_median(seconds, bench->repetitions));
    cJSON_AddNumberToObject(object, "applications", cost.applications);
    cJSON_AddNumberToObject(object, "residual", cost.residual);
    cJSON_AddItemToArray(solvers, object);
    return RSV_OK;
}

static rsv_status measure_relighting(const cli_bench_task *bench, cJSON *result)
{
    size_t floats = (size_t)LIGHTS * RECEIVERS * 3;
    double seconds[MOST_REPETITIONS];
    rsv_device_basis *basis = NULL;
    float *value = calloc(floats, sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_device_basis_create(cli_device(), LIGHTS, RECEIVERS, value, &basis);
    if (status == RSV_OK) status = rsv_device_basis_measure(basis, bench->repetitions, seconds);
    if (status == RSV_OK)
        cJSON_AddNumberToObject(result, "relight_seconds", cli_median(seconds, bench->repetitions));
    rsv_device_basis_destroy(basis);
    free(value);
    return status;
}

/// Rows of the operator once more, receivers and transfers included.
static rsv_status measure_rows(const rsv_light *solution, cJSON *result)
{
    rsv_assembly_cost cost;
    rsv_status status = rsv_measure_assembly(solution, &cost);
    if (status == RSV_OK)
        cJSON_AddNumberToObject(
            result, "row_rays_per_second", (double)cost.rays / cost.assembly_seconds);
    return status;
}

/// The same for direct light of the elements.
static rsv_status measure_direct(const rsv_light *solution, cJSON *result)
{
    double seconds;
    uint64_t rays;
    rsv_status status = rsv_measure_direct(solution, &seconds, &rays);
    if (status == RSV_OK)
        cJSON_AddNumberToObject(result, "shadow_rays_per_second", (double)rays / seconds);
    return status;
}

bool cli_bench_gpu(const cli_bench_task *bench, cJSON *result)
{
    if (!cli_device()) {
        cli_error("bench gpu: which device? --device cuda, or --device emulated for a look");
        return false;
    }
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    rsv_solve_desc desc = cli_bench_solve_desc(bench, bench->quality);
    rsv_light *solution = NULL;
    desc.direct_level = false;
    cli_describe_device(result);
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status == RSV_OK) status = measure_operator(bench, solution, result);
    if (status == RSV_OK) status = measure_rows(solution, result);
    if (status == RSV_OK) status = measure_direct(solution, result);
    cJSON *solvers = cJSON_AddArrayToObject(result, "solvers");
    const rsv_solver timed[] = { RSV_SOLVER_NEUMANN, RSV_SOLVER_CHEBYSHEV, RSV_SOLVER_BICGSTAB };
    for (size_t k = 0; k < sizeof timed / sizeof timed[0] && status == RSV_OK; k++)
        status = measure_solver(bench, solution, timed[k], solvers);
    if (status == RSV_OK) status = measure_relighting(bench, result);
    if (status == RSV_OK) status = cli_measure_gpu_frames(bench, solution, result);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

static const char *text(const cJSON *object, const char *name)
{
    return cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
}

void cli_print_gpu(const cJSON *result)
{
    const cJSON *solver, *device = cJSON_GetObjectItem(result, "device");
    double copied = cli_json_number(result, "copy_bytes_per_second");
    printf("\n%s, compute capability %s, driver for CUDA %s, plug-in of CUDA %s; %.0f elements, "
           "%.3g M "
           "entries\n\n",
        text(device, "name"), text(device, "capability"), text(device, "driver"),
        text(device, "runtime"), cli_json_number(result, "elements"),
        1e-6 * cli_json_number(result, "entries"));
    printf("| what | measured | goal |\n|---|---|---|\n");
    printf("| copy, read and written | %.4g GB/s | |\n", 1e-9 * copied);
    printf("| application of the operator, %.4g MB | %.4g us | |\n",
        1e-6 * cli_json_number(result, "application_bytes"),
        1e6 * cli_json_number(result, "application_seconds"));
    printf("| the same, relative to the copy | %.3g %% | 60 %% |\n",
        100 * cli_json_number(result, "application_over_copy"));
    cJSON_ArrayForEach(solver, cJSON_GetObjectItem(result, "solvers"))
    {
        printf("| %s to a residual of %.0e, %.0f applications | %.4g ms | |\n",
            text(solver, "name"), goal, cli_json_number(solver, "applications"),
            1e3 * cli_json_number(solver, "seconds"));
    }
    printf("| %d receivers relit, %d lights | %.4g ms | 1 ms |\n", RECEIVERS, LIGHTS,
        1e3 * cli_json_number(result, "relight_seconds"));
    printf("| rays of rows, including all of assembly | %.4g M/s | 400 M/s |\n",
        1e-6 * cli_json_number(result, "row_rays_per_second"));
    printf("| shadow rays of direct light, including all other work | %.4g M/s | |\n",
        1e-6 * cli_json_number(result, "shadow_rays_per_second"));
    printf("| frames of %.0fx%.0f | %.4g/s | 1000/s; 500/s with glass spheres |\n\n",
        cli_json_number(result, "frame_width"), cli_json_number(result, "frame_height"),
        1 / cli_json_number(result, "frame_seconds"));
}
