#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool cli_write_quality_csv(const char *path, const cJSON *scenes)
{
    const cJSON *result = cJSON_GetArrayItem(scenes, 0);
    static const char *const columns[] = { "seconds", "cpu_seconds", "median_relative_error",
        "error_without_reference", "time_factor", "relative_mse", "mse_without_reference",
        "mse_time_factor", "mean_ratio" };
    enum { column_count = sizeof columns / sizeof columns[0] };
    char *text = NULL;
    size_t length = 0;
    FILE *csv = open_memstream(&text, &length);
    if (!csv) return false;
    fputs("mode,picture,spp", csv);
    for (size_t i = 0; i < column_count; i++)
        fprintf(csv, ",%s", columns[i]);
    const cJSON *point;
    cJSON_ArrayForEach(point, cJSON_GetObjectItem(result, "points"))
    {
        fprintf(csv, "\n%s,\"%s\",%.0f", cJSON_GetStringValue(cJSON_GetObjectItem(point, "mode")),
            cJSON_GetStringValue(cJSON_GetObjectItem(point, "name")),
            cli_json_number(point, "spp"));
        for (size_t i = 0; i < column_count; i++)
            fprintf(csv, ",%.6g", cli_json_number(point, columns[i]));
    }
    fputc('\n', csv);
    bool written = fclose(csv) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}

enum { plot_width = 720, plot_height = 440 };

/// Whole decades around the points and the extrapolated reference.
static void fit_axes(cli_plot *p, const cJSON *points)
{
    double low_time = INFINITY, high_time = 0, low_error = INFINITY, high_error = 0;
    const cJSON *point;
    cJSON_ArrayForEach(point, points)
    {
        double seconds = cli_json_number(point, "seconds");
        double error = cli_json_number(point, "error_without_reference");
        low_time = fmin(low_time, seconds);
        high_time = fmax(high_time, fmax(seconds, cli_json_number(point, "reference_seconds")));
        low_error = fmin(low_error, error);
        high_error = fmax(high_error, error);
    }
    p->x = (cli_axis){ .from = 70, .to = plot_width - 20, .format = "%g s", .unit = 1 };
    p->y = (cli_axis){ .from = plot_height - 60, .to = 20, .format = "%g %%", .unit = 0.01 };
    cli_axis_cover(&p->x, low_time, high_time);
    cli_axis_cover(&p->y, low_error, high_error);
}

static bool belongs_to(const cJSON *point, const char *curve)
{
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(point, "curve"));
    return name && strcmp(name, curve) == 0;
}

/// The points of one curve, joined and named.
static void draw_curve(const cli_plot *p, const cJSON *points, const char *curve)
{
    double before[2] = { 0 };
    const cJSON *point;
    cJSON_ArrayForEach(point, points)
    {
        if (!belongs_to(point, curve)) continue;
        double here[2] = { cli_json_number(point, "seconds"),
            cli_json_number(point, "error_without_reference") };
        double x = cli_axis_place(&p->x, here[0]), y = cli_axis_place(&p->y, here[1]);
        if (before[0] > 0) cli_plot_line(p, before, here, curve);
        fprintf(p->svg, "<circle cx='%.1f' cy='%.1f' r='4' class='%s'/>\n", x, y, curve);
        fprintf(p->svg, "<text x='%.1f' y='%.1f'>%s</text>\n", x + 9, y - 6,
            cJSON_GetStringValue(cJSON_GetObjectItem(point, "name")));
        memcpy(before, here, sizeof before);
    }
}

/// The reference mode continued as 1 / sqrt(time) to the best picture's error.
static void draw_extrapolation(const cli_plot *p, const cJSON *points)
{
    const cJSON *last = cJSON_GetArrayItem(points, cJSON_GetArraySize(points) - 1), *point;
    double end[2] = { 0, INFINITY };
    cJSON_ArrayForEach(point, points)
    {
        double error = cli_json_number(point, "error_without_reference");
        if (!belongs_to(point, "final") || error >= end[1]) continue;
        end[0] = cli_json_number(point, "reference_seconds");
        end[1] = error;
    }
    double start[2] = { cli_json_number(last, "seconds"),
        cli_json_number(last, "error_without_reference") };
    cli_plot_line(p, start, end, "continued");
}

static void draw_plot(const cli_plot *p, const cJSON *points)
{
    fprintf(p->svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none} text{fill:#333} .grid{stroke:#eee} "
        ".decade{stroke:#bbb} path.final{stroke:#c8401f;stroke-width:2} circle.final{fill:#c8401f} "
        "path.reference,.continued{stroke:#2a5d9f;stroke-width:2} .continued{stroke-dasharray:5 5} "
        "circle.reference{fill:#2a5d9f}</style>\n<rect width='100%%' height='100%%' "
        "fill='#fff'/>\n",
        plot_width, plot_height);
    cli_plot_grid(p);
    draw_extrapolation(p, points);
    draw_curve(p, points, "final");
    draw_curve(p, points, "reference");
    fprintf(p->svg,
        "<text x='%d' y='%d' text-anchor='middle'>time from scene to picture</text>\n"
        "<text transform='translate(16 %d) rotate(-90)' text-anchor='middle'>median relative "
        "error</text>\n</svg>\n",
        plot_width / 2, plot_height - 16, plot_height / 2 - 20);
}

bool cli_write_quality_plot(const char *path, const cJSON *scenes)
{
    const cJSON *result = cJSON_GetArrayItem(scenes, 0);
    char *text = NULL;
    size_t length = 0;
    cli_plot p = { .svg = open_memstream(&text, &length) };
    if (!p.svg) return false;
    const cJSON *points = cJSON_GetObjectItem(result, "points");
    fit_axes(&p, points);
    draw_plot(&p, points);
    bool written = fclose(p.svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
