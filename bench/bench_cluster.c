#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include "resolvent/measure.h"
#include "resolvent/solve.h"

#include <cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Elements of terraces, against their triangles: four squares apart.
#define TRIANGLES_PER_ELEMENT 32

static const uint32_t parts[] = { 2, 4, 8, 16, 32, 64 };
enum { part_counts = sizeof parts / sizeof parts[0] };

static void add_divisions(
    cJSON *result, const rsv_solve_report *report, const rsv_division_cost *cost)
{
    cJSON_AddNumberToObject(result, "rows", (double)report->rows);
    cJSON_AddNumberToObject(result, "entries", (double)report->entries);
    cJSON_AddNumberToObject(result, "field", 3.0 * (double)report->elements);
    cJSON *list = cJSON_AddArrayToObject(result, "divisions");
    for (size_t k = 0; k < part_counts; k++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddNumberToObject(item, "parts", cost[k].parts);
        cJSON_AddNumberToObject(item, "imbalance", cost[k].imbalance);
        cJSON_AddNumberToObject(item, "received_mean", cost[k].received_mean);
        cJSON_AddNumberToObject(item, "received_most", cost[k].received_most);
        cJSON_AddNumberToObject(item, "senders_mean", cost[k].senders_mean);
        cJSON_AddItemToArray(list, item);
    }
}

bool cli_bench_cluster(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.direct_level = false;
    if (strncmp(bench->scene, "terraces", strlen("terraces")) == 0)
        desc.element_target =
            (uint32_t)(rsv_scene_get_view(scene)->triangle_count / TRIANGLES_PER_ELEMENT);
    rsv_light *solution = NULL;
    rsv_division_cost cost[part_counts];
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    if (status == RSV_OK) status = rsv_measure_division(solution, parts, part_counts, cost);
    if (status == RSV_OK)
        add_divisions(result, rsv_light_report(solution), cost);
    else
        cli_report_failure(bench->session, status);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    return status == RSV_OK && cli_measure_scaling(bench, result);
}

void cli_print_cluster(const cJSON *result)
{
    const cJSON *division;
    printf("  %.0f rows, %.0f entries, %.0f numbers a field\n", cli_json_number(result, "rows"),
        cli_json_number(result, "entries"), cli_json_number(result, "field"));
    printf(
        "  %5s %14s %28s %8s\n", "parts", "dearest/mean", "numbers received, mean/most", "senders");
    cJSON_ArrayForEach(division, cJSON_GetObjectItem(result, "divisions"))
        printf("  %5.0f %14.3f %15.0f %12.0f %8.1f\n", cli_json_number(division, "parts"),
            cli_json_number(division, "imbalance"), cli_json_number(division, "received_mean"),
            cli_json_number(division, "received_most"), cli_json_number(division, "senders_mean"));
    cli_print_scaling(result);
}

/// The divisions of all scenes, each with the scene's name.
static cJSON *flatten(const cJSON *scenes)
{
    cJSON *rows = cJSON_CreateArray();
    const cJSON *scene, *division;
    cJSON_ArrayForEach(scene, scenes)
    {
        const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene"));
        cJSON_ArrayForEach(division, cJSON_GetObjectItem(scene, "divisions"))
        {
            cJSON *row = cJSON_Duplicate(division, true);
            cJSON_AddStringToObject(row, "scene", name);
            cJSON_AddNumberToObject(row, "rows", cli_json_number(scene, "rows"));
            cJSON_AddNumberToObject(row, "field", cli_json_number(scene, "field"));
            cJSON_AddItemToArray(rows, row);
        }
    }
    return rows;
}

bool cli_write_cluster_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "rows", "field", "parts", "imbalance", "received_mean",
        "received_most", "senders_mean" };
    cJSON *rows = flatten(scenes);
    bool written = cli_write_columns(path, rows, columns, sizeof columns / sizeof columns[0]);
    cJSON_Delete(rows);
    return written;
}

enum { plot_width = 560, plot_height = 360 };

/// Data that parts receive, as a share of a field, over the number of parts.
static void draw_scene(cli_plot *p, const cJSON *scene, const char *style)
{
    const cJSON *division;
    double field = cli_json_number(scene, "field"), before[2] = { 0, 0 };
    cJSON_ArrayForEach(division, cJSON_GetObjectItem(scene, "divisions"))
    {
        double at[2] = { cli_json_number(division, "parts"),
            cli_json_number(division, "received_mean") / field };
        if (before[0] > 0) cli_plot_line(p, before, at, style);
        before[0] = at[0];
        before[1] = at[1];
    }
    fprintf(p->svg, "<text x='%.0f' y='%.0f' class='%s'>%s</text>\n",
        cli_axis_place(&p->x, before[0]) - 90, cli_axis_place(&p->y, before[1]) - 8, style,
        cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")));
}

bool cli_write_cluster_plot(const char *path, const cJSON *scenes)
{
    static const char *const styles[] = { "first", "second", "third" };
    char *text = NULL;
    size_t length = 0;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    cli_plot p = { svg, { .from = 70, .to = plot_width - 20, .format = "%g", .unit = 1 },
        { .from = plot_height - 50, .to = 40, .format = "%g %%", .unit = 0.01 } };
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none} text{fill:#333} .grid{stroke:#eee} "
        ".decade{stroke:#bbb} path.first{stroke:#2a5d9f;stroke-width:2} "
        "path.second{stroke:#c8401f;stroke-width:2} path.third{stroke:#4a8a3a;stroke-width:2}"
        "</style>\n<rect width='100%%' height='100%%' fill='#fff'/>\n"
        "<text x='70' y='22'>what a part receives for one application, as a share of a "
        "field</text>\n"
        "<text x='%d' y='%d' text-anchor='middle'>parts</text>\n",
        plot_width, plot_height, plot_width / 2, plot_height - 8);
    cli_axis_cover(&p.x, parts[0], parts[part_counts - 1]);
    cli_axis_cover(&p.y, 0.011, 1);
    cli_plot_grid(&p);
    for (int k = 0; k < cJSON_GetArraySize(scenes); k++)
        draw_scene(&p, cJSON_GetArrayItem(scenes, k), styles[k % 3]);
    fprintf(svg, "</svg>\n");
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
