/// Interactive relighting: the strengths of all lights changed, and one light moved.
#include "benchmarks.h"

#include "resolvent/relight.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/// About 100,000 vertices, each of which receives light.
enum { body_triangles = 200000, most_sources = 64, most_steps = 1000 };

/// Metres that the light moves by, to and fro.
static const float stride = 0.01f;

/// Times of one kind of change, [repetitions] each.
typedef struct change_times {
    double *source_ms; ///< until E0 is that of the new lights
    double *solve_ms;  ///< until the residual is below 1e-3 of it
    double *orders;
    double *bare_ms; ///< of as many bare shadow rays
    double *ratio;   ///< of source_ms to that
} change_times;

enum { figures = 5 }; ///< of change_times

static rsv_status measure_change(
    rsv_relighter *relighter, const rsv_relight_desc *desc, const change_times *t, uint32_t k)
{
    rsv_relight_progress progress = { .converged = false };
    double start = cli_seconds(), orders = 0;
    rsv_status status = rsv_relighter_change(relighter, desc);
    double changed = cli_seconds();
    for (int step = 0; status == RSV_OK && !progress.converged && step < most_steps; step++) {
        status = rsv_relighter_step(relighter, 0, &progress);
        orders += progress.orders;
    }
    t->source_ms[k] = 1e3 * (changed - start);
    t->solve_ms[k] = 1e3 * (cli_seconds() - changed);
    t->orders[k] = orders;
    return status;
}

/// All strengths up and down in turn.
static rsv_status change_strengths(rsv_relighter *relighter, const change_times *t, uint32_t k)
{
    rsv_light_scale scale[most_sources];
    float factor = k % 2 ? 0.5f : 2;
    size_t count = rsv_relighter_source_count(relighter);
    for (size_t i = 0; i < count; i++)
        scale[i] = (rsv_light_scale){ rsv_relighter_source(relighter, i).name,
            { factor, factor, factor } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = scale, .light_count = count };
    return measure_change(relighter, &desc, t, k);
}

static rsv_status move_light(
    rsv_relighter *relighter, size_t source, const change_times *t, uint32_t k)
{
    const rsv_light_move move = { rsv_relighter_source(relighter, source).name,
        { k % 2 ? stride : -stride, 0, 0 } };
    const rsv_relight_desc desc = { .size = sizeof desc, .move = &move, .move_count = 1 };
    return measure_change(relighter, &desc, t, k);
}

static size_t find_movable(const rsv_relighter *relighter)
{
    size_t k = 0, count = rsv_relighter_source_count(relighter);
    while (k < count && !rsv_relighter_source(relighter, k).movable)
        k++;
    return k;
}

static void add_medians(
    cJSON *result, const char *const *names, const change_times *t, uint32_t count)
{
    double *const values[figures] = { t->source_ms, t->solve_ms, t->orders, t->bare_ms, t->ratio };
    for (int k = 0; k < figures && names[k]; k++)
        cJSON_AddNumberToObject(result, names[k], cli_median(values[k], count));
}

static rsv_status measure_strengths(
    const cli_bench_task *bench, rsv_relighter *relighter, const change_times *t, cJSON *result)
{
    static const char *const names[figures] = { "scaled_source_ms", "scaled_solve_ms",
        "scaled_orders" };
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < bench->repetitions && !status && !cli_interrupted(); k++)
        status = change_strengths(relighter, t, k);
    if (!status) add_medians(result, names, t, bench->repetitions);
    return status;
}

/// By turns with as many shadow rays of vertices towards where the light is.
static rsv_status compare_moves(const cli_bench_task *bench, rsv_relighter *relighter,
    size_t source, const cli_shadow_rays *bare, const change_times *t)
{
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < bench->repetitions && !status && !cli_interrupted(); k++) {
        status = move_light(relighter, source, t, k);
        t->bare_ms[k] = 1e3 * cli_shadow_rays_time(bare, false);
        t->ratio[k] = t->source_ms[k] / t->bare_ms[k];
    }
    return status;
}

/// The first move includes setup that the others share.
static rsv_status measure_moves(const cli_bench_task *bench, const rsv_scene *scene,
    rsv_relighter *relighter, const change_times *t, cJSON *result)
{
    static const char *const names[figures] = { "moved_source_ms", "moved_solve_ms", "moved_orders",
        "bare_rays_ms", "moved_over_bare" };
    size_t source = find_movable(relighter);
    if (source == rsv_relighter_source_count(relighter)) return RSV_OK;
    cli_shadow_rays *bare = NULL;
    rsv_status status = move_light(relighter, source, t, 1);
    cJSON_AddNumberToObject(result, "first_move_ms", t->source_ms[1]);
    uint64_t before = rsv_relighter_rays(relighter);
    if (!status) status = move_light(relighter, source, t, 0);
    size_t rays = (size_t)(rsv_relighter_rays(relighter) - before);
    cJSON_AddNumberToObject(result, "moved_rays", (double)rays);
    if (!status)
        status = cli_shadow_rays_create(
            scene, rsv_relighter_source(relighter, source).position, rays, bench->threads, &bare);
    if (!status) status = compare_moves(bench, relighter, source, bare, t);
    if (!status) add_medians(result, names, t, bench->repetitions);
    cli_shadow_rays_destroy(bare);
    return status;
}

static rsv_status measure_relighter(
    const cli_bench_task *bench, const rsv_scene *scene, rsv_relighter *relighter, cJSON *result)
{
    size_t n = bench->repetitions > 2 ? bench->repetitions : 2;
    double *times = calloc(figures * n, sizeof *times);
    const change_times t = { times, times + n, times + 2 * n, times + 3 * n, times + 4 * n };
    rsv_status status = times ? RSV_OK : RSV_ERROR_MEMORY;
    if (!status) status = measure_strengths(bench, relighter, &t, result);
    if (!status) status = measure_moves(bench, scene, relighter, &t, result);
    double start = cli_seconds();
    if (!status) status = rsv_relighter_settle(relighter);
    cJSON_AddNumberToObject(result, "settle_ms", 1e3 * (cli_seconds() - start));
    free(times);
    return status;
}

static rsv_status measure(const cli_bench_task *bench, rsv_scene *scene, cJSON *result)
{
    rsv_solve_desc desc = cli_bench_solve_desc(bench, RSV_QUALITY_DRAFT);
    rsv_light *solution = NULL;
    rsv_relighter *relighter = NULL;
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (!status) status = rsv_relighter_create(solution, &relighter);
    if (!status) {
        const rsv_solve_report *report = rsv_light_report(solution);
        cJSON_AddNumberToObject(result, "receivers", (double)report->elements);
        cJSON_AddNumberToObject(result, "direct_elements", (double)report->direct_elements);
        cJSON_AddNumberToObject(result, "entries", (double)report->entries);
        double start = cli_seconds();
        status = rsv_relighter_prepare(relighter);
        cJSON_AddNumberToObject(result, "prepare_ms", 1e3 * (cli_seconds() - start));
        if (!status) status = measure_relighter(bench, scene, relighter, result);
    }
    if (!status && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    rsv_relighter_destroy(relighter);
    rsv_light_destroy(solution);
    return status;
}

bool cli_bench_move(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_body(bench, body_triangles);
    if (!scene) return false;
    rsv_status status = measure(bench, scene, result);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_move(const cJSON *result)
{
    printf("  %.0f receivers, %.0f entries; %.0f elements of direct light and caustics\n",
        cli_json_number(result, "receivers"), cli_json_number(result, "entries"),
        cli_json_number(result, "direct_elements"));
    printf(
        "  all strengths changed  sources %.1f ms, to a residual of 1e-3 %.1f ms (%.0f orders)\n",
        cli_json_number(result, "scaled_source_ms"), cli_json_number(result, "scaled_solve_ms"),
        cli_json_number(result, "scaled_orders"));
    if (cJSON_GetObjectItem(result, "moved_source_ms")) {
        printf("  one light moved        its light %.1f ms, to a residual of 1e-3 %.1f ms (%.0f "
               "orders)\n",
            cli_json_number(result, "moved_source_ms"), cli_json_number(result, "moved_solve_ms"),
            cli_json_number(result, "moved_orders"));
        printf("                         %.0f shadow rays, which alone take %.1f ms: %.2f times "
               "that (the first move: %.0f ms)\n",
            cli_json_number(result, "moved_rays"), cli_json_number(result, "bare_rays_ms"),
            cli_json_number(result, "moved_over_bare"), cli_json_number(result, "first_move_ms"));
    }
    printf("  exact                  %.1f ms; all of it prepared in %.0f ms\n",
        cli_json_number(result, "settle_ms"), cli_json_number(result, "prepare_ms"));
}

bool cli_write_move_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "receivers", "direct_elements", "entries",
        "scaled_source_ms", "scaled_solve_ms", "scaled_orders", "moved_source_ms", "moved_solve_ms",
        "moved_orders", "moved_rays", "bare_rays_ms", "moved_over_bare", "first_move_ms",
        "settle_ms", "prepare_ms" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}
