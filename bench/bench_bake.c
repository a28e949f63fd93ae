/// Bakes compared with path tracing: time, errors of texels and vertices, blotches, seams, bytes.
#include "baked_values.h"
#include "command.h"
#include "judged_view.h"
#include "room_files.h"
#include "scratch_folder.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>

#define RANDOM_VALUES 256
#define WINDOWS 6
#define PATHS 4096

static const char *const targets[] = { "lightmap", "vertex" };
enum { target_count = sizeof targets / sizeof targets[0] };

typedef struct measurement {
    const cli_bench_task *bench;
    const char *target;
    rsv_scene *scene;
    rsv_light *light;
    cli_cost solve, bake;
    rsv_bake_report report;
    cli_bake_judgement judgement;
    double bytes;
} measurement;

static cJSON *describe(const measurement *m)
{
    const cli_bake_judgement *j = &m->judgement;
    const struct {
        const char *name;
        double value;
    } numbers[] = { { "solve_cpu_seconds", m->solve.cpu_seconds },
        { "bake_cpu_seconds", m->bake.cpu_seconds }, { "bake_seconds", m->bake.seconds },
        { "values", (double)j->values }, { "median_error", j->median }, { "error_90", j->ninety },
        { "error_99", j->ninety_nine }, { "buried", (double)j->buried },
        { "reference_noise", j->noise }, { "mean_ratio", j->mean_ratio },
        { "largest_blotch", (double)j->blotch }, { "largest_seam", m->report.largest_seam },
        { "bytes", m->bytes } };
    cJSON *one = cJSON_CreateObject();
    cJSON_AddStringToObject(one, "to", m->target);
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
        cJSON_AddNumberToObject(one, numbers[k].name, numbers[k].value);
    return one;
}

/// Bakes into a folder that is removed afterwards.
static rsv_status bake(measurement *m, const rsv_bake_visitor *visitor, bool *made)
{
    char folder[PATH_MAX], output[PATH_MAX + 16];
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.map_size = m->bench->size;
    desc.visitor = visitor;
    *made = cli_make_scratch_folder("bake", folder);
    if (!*made) return RSV_ERROR_IO;
    snprintf(output, sizeof output, "%s/room.glb", folder);
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_bake(m->light, m->target, output, &desc, &m->report);
    m->bake = cli_cost_since(started);
    m->bytes = cli_scratch_folder_bytes(folder);
    cli_remove_scratch_folder(folder);
    return status;
}

static rsv_status measure_target(measurement *m, bool *made)
{
    cli_baked_values values = { .random_count = RANDOM_VALUES, .window_count = WINDOWS };
    const rsv_bake_visitor visitor = cli_baked_values_visitor(&values);
    uint32_t paths = m->bench->paths ? m->bench->paths : PATHS;
    rsv_status status = bake(m, &visitor, made);
    if (status == RSV_OK) status = cli_judge_baked_values(m->scene, &values, paths, &m->judgement);
    cli_baked_values_free(&values);
    return status;
}

static rsv_status measure(measurement *m, cJSON *result, bool *made)
{
    rsv_solve_desc desc = cli_bench_solve_desc(m->bench, m->bench->quality);
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_light_create(m->scene, &desc, &m->light);
    m->solve = cli_cost_since(started);
    cJSON *list = cJSON_AddArrayToObject(result, "targets");
    for (size_t k = 0; k < target_count && status == RSV_OK; k++) {
        m->target = targets[k];
        status = measure_target(m, made);
        if (status == RSV_OK) cJSON_AddItemToArray(list, describe(m));
    }
    rsv_light_destroy(m->light);
    return status;
}

bool cli_bench_bake(const cli_bench_task *bench, cJSON *result)
{
    cli_room_files room;
    measurement m = { .bench = bench };
    bool made = true;
    if (!cli_find_room(bench, "bake", &room)) return false;
    if (cli_room_is_missing(&room, result)) return true;
    cli_environment environment = bench->environment;
    if (room.environment[0]) environment.path = room.environment;
    bench->session->keep_document = true;
    m.scene = cli_open_scene(bench->session, room.scene, &environment);
    if (!m.scene) return false;
    rsv_status status = measure(&m, result, &made);
    rsv_scene_destroy(m.scene);
    if (!made)
        cli_error("bench bake: cannot make a folder for temporary files; set TMPDIR to a place for "
                  "them");
    else if (status != RSV_OK)
        cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_bake(const cJSON *result)
{
    const cJSON *skipped = cJSON_GetObjectItem(result, "skipped"), *one;
    if (skipped) printf("  skipped: %s\n", cJSON_GetStringValue(skipped));
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "targets"))
    {
        printf("  %-9s solved in %.3g s of CPU time, baked in %.3g s\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(one, "to")),
            cli_json_number(one, "solve_cpu_seconds"), cli_json_number(one, "bake_cpu_seconds"));
        printf(
            "            error: median %.2f %%, 90th percentile %.2f %%, 99th %.2f %%; mean ratio "
            "%.4f; %.0f values\n",
            100 * cli_json_number(one, "median_error"), 100 * cli_json_number(one, "error_90"),
            100 * cli_json_number(one, "error_99"), cli_json_number(one, "mean_ratio"),
            cli_json_number(one, "values"));
        printf("            noise of path tracing: median %.2f %%\n",
            100 * cli_json_number(one, "reference_noise"));
        printf("            largest blotch %.0f texels, largest seam %.2f %%, %.3g MB\n",
            cli_json_number(one, "largest_blotch"), 100 * cli_json_number(one, "largest_seam"),
            1e-6 * cli_json_number(one, "bytes"));
    }
}

static cJSON *flatten(const cJSON *scenes)
{
    const cJSON *s, *one;
    cJSON *rows = cJSON_CreateArray();
    cJSON_ArrayForEach(s, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(s, "targets"))
        {
            char name[160];
            snprintf(name, sizeof name, "%s: %s",
                cJSON_GetStringValue(cJSON_GetObjectItem(s, "scene")),
                cJSON_GetStringValue(cJSON_GetObjectItem(one, "to")));
            cJSON *row = cJSON_Duplicate(one, true);
            cJSON_AddStringToObject(row, "scene", name);
            cJSON_AddItemToArray(rows, row);
        }
    }
    return rows;
}

bool cli_write_bake_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "solve_cpu_seconds", "bake_cpu_seconds", "median_error",
        "error_90", "error_99", "reference_noise", "mean_ratio", "largest_blotch", "largest_seam",
        "bytes" };
    cJSON *rows = flatten(scenes);
    bool written = cli_write_columns(path, rows, columns, sizeof columns / sizeof columns[0]);
    cJSON_Delete(rows);
    return written;
}

/// A table in Markdown, for docs/benchmarks.md.
void cli_print_bake_summary(const cJSON *scenes)
{
    const cJSON *row;
    cJSON *rows = flatten(scenes);
    puts(
        "\n| room | solve, CPU s | bake, CPU s | median error | 90 % | 99 % | path tracing alone | "
        "mean ratio | largest blotch | largest seam | MB "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|");
    cJSON_ArrayForEach(row, rows) printf(
        "| %s | %.1f | %.1f | %.2f %% | %.2f %% | %.2f %% | %.2f %% | %.4f | %.0f | %.2f %% | "
        "%.2f |\n",
        cJSON_GetStringValue(cJSON_GetObjectItem(row, "scene")),
        cli_json_number(row, "solve_cpu_seconds"), cli_json_number(row, "bake_cpu_seconds"),
        100 * cli_json_number(row, "median_error"), 100 * cli_json_number(row, "error_90"),
        100 * cli_json_number(row, "error_99"), 100 * cli_json_number(row, "reference_noise"),
        cli_json_number(row, "mean_ratio"), cli_json_number(row, "largest_blotch"),
        100 * cli_json_number(row, "largest_seam"), 1e-6 * cli_json_number(row, "bytes"));
    cJSON_Delete(rows);
}
