#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *text_of(const cJSON *object, const char *name)
{
    return cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
}

static double number_at(const cJSON *row, int index)
{
    return cJSON_GetArrayItem(row, index)->valuedouble;
}

static void write_rows(FILE *csv, const cJSON *scene, const cJSON *solver)
{
    const cJSON *row;
    cJSON_ArrayForEach(row, cJSON_GetObjectItem(solver, "history"))
    {
        fprintf(csv, "\n%s,%s,%.6g,%.6g,%.6g", text_of(scene, "scene"), text_of(solver, "name"),
            number_at(row, 0), number_at(row, 1), number_at(row, 2));
    }
}

bool cli_write_solvers_csv(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *csv = open_memstream(&text, &length);
    if (!csv) return false;
    fputs("scene,solver,applications,seconds,residual", csv);
    const cJSON *scene, *solver;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(solver, cJSON_GetObjectItem(scene, "solvers"))
            write_rows(csv, scene, solver);
    }
    fputc('\n', csv);
    bool written = fclose(csv) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}

enum { panel_width = 480, panel_height = 360, legend_height = 40 };

/// The columns of a history: the x axes, and the quantity plotted.
enum { applications, seconds, residual };

/// Range of a column over all solvers of a scene, at most `decades`: smaller values are not plotted.
static void cover(cli_axis *axis, const cJSON *scene, int column, double decades)
{
    double low = INFINITY, high = 0;
    const cJSON *solver, *row;
    cJSON_ArrayForEach(solver, cJSON_GetObjectItem(scene, "solvers"))
    {
        cJSON_ArrayForEach(row, cJSON_GetObjectItem(solver, "history"))
        {
            double value = number_at(row, column);
            if (value > 0) low = fmin(low, value);
            high = fmax(high, value);
        }
    }
    low = fmax(low, high * pow(10, -decades));
    cli_axis_cover(axis, low, high > low ? high : 10 * low);
}

static void draw_curve(const cli_plot *p, const cJSON *solver, int column)
{
    double before[2] = { 0 };
    const cJSON *row;
    cJSON_ArrayForEach(row, cJSON_GetObjectItem(solver, "history"))
    {
        double here[2] = { number_at(row, column), number_at(row, residual) };
        if (here[0] < p->x.low || here[1] < p->y.low) continue;
        if (before[0] > 0) cli_plot_line(p, before, here, text_of(solver, "name"));
        memcpy(before, here, sizeof before);
    }
}

static void draw_panel(FILE *svg, const cJSON *scene, int index, int column)
{
    double left = column == seconds ? panel_width : 0, top = legend_height + panel_height * index;
    cli_plot p = { .svg = svg,
        .x = { .from = left + 70,
            .to = left + panel_width - 20,
            .format = column == seconds ? "%g ms" : "%g",
            .unit = column == seconds ? 1e-3 : 1 },
        .y = { .from = top + panel_height - 60, .to = top + 30, .format = "%.0e", .unit = 1 } };
    cover(&p.x, scene, column, column == seconds ? 2.5 : 2);
    cover(&p.y, scene, residual, 8);
    cli_plot_grid(&p);
    const cJSON *solver;
    cJSON_ArrayForEach(solver, cJSON_GetObjectItem(scene, "solvers"))
        draw_curve(&p, solver, column);
    fprintf(svg, "<text x='%.0f' y='%.0f' text-anchor='middle'>%s: residual over %s</text>\n",
        left + 0.5 * panel_width + 25, top + 20, text_of(scene, "scene"),
        column == seconds ? "time" : "applications of the operator");
}

/// Colours of the curves, in the order of the solvers; `auto` is the first.
static const char *const colours[] = { "#c8401f;stroke-dasharray:4 3", "#222", "#8a6d3b", "#b5a51e",
    "#2a9d4f", "#8e44ad", "#2a5d9f", "#e0832b", "#d5479b", "#5fa8a8" };
enum { colour_count = sizeof colours / sizeof colours[0] };

static void draw_head(FILE *svg, const cJSON *scenes)
{
    const cJSON *solvers = cJSON_GetObjectItem(cJSON_GetArrayItem(scenes, 0), "solvers"), *solver;
    int index = 0;
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none;stroke-width:2} text{fill:#333} "
        "path.grid{stroke:#eee;stroke-width:1} path.decade{stroke:#bbb;stroke-width:1}",
        2 * panel_width, legend_height + cJSON_GetArraySize(scenes) * panel_height);
    cJSON_ArrayForEach(solver, solvers) fprintf(
        svg, " path.%s{stroke:%s}", text_of(solver, "name"), colours[index++ % colour_count]);
    fputs("</style>\n<rect width='100%' height='100%' fill='#fff'/>\n", svg);
    index = 0;
    cJSON_ArrayForEach(solver, solvers)
    {
        fprintf(svg, "<path d='M%d 20h24' class='%s'/><text x='%d' y='24'>%s</text>\n",
            70 + 110 * index, text_of(solver, "name"), 100 + 110 * index, text_of(solver, "name"));
        index++;
    }
}

bool cli_write_solvers_plot(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    draw_head(svg, scenes);
    const cJSON *scene;
    int index = 0;
    cJSON_ArrayForEach(scene, scenes)
    {
        draw_panel(svg, scene, index, applications);
        draw_panel(svg, scene, index++, seconds);
    }
    fputs("</svg>\n", svg);
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
