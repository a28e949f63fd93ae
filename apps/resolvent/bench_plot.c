#include "bench.h"
#include "output_file.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool cli_write_quality_csv(const char *path, const cJSON *result)
{
    static const char *const columns[] = { "seconds", "cpu_seconds", "median_relative_error",
        "error_without_reference", "relative_mse", "mean_ratio", "time_factor" };
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

/// A range of values shown on a logarithmic axis between two places of the picture.
typedef struct log_axis {
    double low, high; ///< powers of ten
    double from, to;  ///< pixels
} log_axis;

typedef struct plot {
    FILE *svg;
    log_axis time, error;
} plot;

enum { plot_width = 720, plot_height = 440 };

static double place(const log_axis *axis, double value)
{
    return axis->from +
           (axis->to - axis->from) * log10(value / axis->low) / log10(axis->high / axis->low);
}

/// Whole decades around what the points, and the reference continued to them, cover.
static void fit_axes(plot *p, const cJSON *points)
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
    p->time = (log_axis){ pow(10, floor(log10(low_time))), pow(10, ceil(log10(high_time))), 70,
        plot_width - 20 };
    p->error = (log_axis){ pow(10, floor(log10(low_error))), pow(10, ceil(log10(high_error))),
        plot_height - 60, 20 };
}

static void draw_line(const plot *p, const double from[2], const double to[2], const char *style)
{
    fprintf(p->svg, "<path d='M%.1f %.1fL%.1f %.1f' class='%s'/>\n", place(&p->time, from[0]),
        place(&p->error, from[1]), place(&p->time, to[0]), place(&p->error, to[1]), style);
}

static void draw_time_grid(const plot *p)
{
    for (double decade = p->time.low; decade < 1.5 * p->time.high; decade *= 10) {
        for (int digit = 1; digit < 10 && digit * decade < 1.01 * p->time.high; digit++)
            draw_line(p, (double[]){ digit * decade, p->error.low },
                (double[]){ digit * decade, p->error.high }, digit == 1 ? "decade" : "grid");
        fprintf(p->svg, "<text x='%.1f' y='%.1f' text-anchor='middle'>%g s</text>\n",
            place(&p->time, decade), p->error.from + 20, decade);
    }
}

static void draw_error_grid(const plot *p)
{
    for (double decade = p->error.low; decade < 1.5 * p->error.high; decade *= 10) {
        for (int digit = 1; digit < 10 && digit * decade < 1.01 * p->error.high; digit++)
            draw_line(p, (double[]){ p->time.low, digit * decade },
                (double[]){ p->time.high, digit * decade }, digit == 1 ? "decade" : "grid");
        fprintf(p->svg, "<text x='%.1f' y='%.1f' text-anchor='end'>%g %%</text>\n",
            p->time.from - 8, place(&p->error, decade) + 4, 100 * decade);
    }
}

/// The points of one mode, joined and named.
static void draw_series(const plot *p, const cJSON *points, const char *mode)
{
    double before[2] = { 0 };
    const cJSON *point;
    cJSON_ArrayForEach(point, points)
    {
        if (strcmp(cJSON_GetStringValue(cJSON_GetObjectItem(point, "mode")), mode) != 0) continue;
        double here[2] = { cli_json_number(point, "seconds"),
            cli_json_number(point, "error_without_reference") };
        double x = place(&p->time, here[0]), y = place(&p->error, here[1]);
        if (before[0] > 0) draw_line(p, before, here, mode);
        fprintf(p->svg, "<circle cx='%.1f' cy='%.1f' r='4' class='%s'/>\n", x, y, mode);
        fprintf(p->svg, "<text x='%.1f' y='%.1f'>%s</text>\n", x + 9, y - 6,
            cJSON_GetStringValue(cJSON_GetObjectItem(point, "name")));
        memcpy(before, here, sizeof before);
    }
}

/// The reference mode continued as 1 / sqrt(time) to the best picture's error.
static void draw_extrapolation(const plot *p, const cJSON *points)
{
    const cJSON *last = cJSON_GetArrayItem(points, cJSON_GetArraySize(points) - 1), *point;
    double end[2] = { 0, INFINITY };
    cJSON_ArrayForEach(point, points)
    {
        double error = cli_json_number(point, "error_without_reference");
        if (error >= end[1]) continue;
        end[0] = cli_json_number(point, "reference_seconds");
        end[1] = error;
    }
    double start[2] = { cli_json_number(last, "seconds"),
        cli_json_number(last, "error_without_reference") };
    draw_line(p, start, end, "continued");
}

static void draw_plot(plot *p, const cJSON *points)
{
    fprintf(p->svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none} text{fill:#333} .grid{stroke:#eee} "
        ".decade{stroke:#bbb} path.final{stroke:#c8401f;stroke-width:2} circle.final{fill:#c8401f} "
        "path.reference,.continued{stroke:#2a5d9f;stroke-width:2} .continued{stroke-dasharray:5 5} "
        "circle.reference{fill:#2a5d9f}</style>\n<rect width='100%%' height='100%%' "
        "fill='#fff'/>\n",
        plot_width, plot_height);
    draw_time_grid(p);
    draw_error_grid(p);
    draw_extrapolation(p, points);
    draw_series(p, points, "final");
    draw_series(p, points, "reference");
    fprintf(p->svg,
        "<text x='%d' y='%d' text-anchor='middle'>time from scene to picture</text>\n"
        "<text transform='translate(16 %d) rotate(-90)' text-anchor='middle'>median relative "
        "error</text>\n</svg>\n",
        plot_width / 2, plot_height - 16, plot_height / 2 - 20);
}

bool cli_write_quality_plot(const char *path, const cJSON *result)
{
    char *text = NULL;
    size_t length = 0;
    plot p = { .svg = open_memstream(&text, &length) };
    if (!p.svg) return false;
    const cJSON *points = cJSON_GetObjectItem(result, "points");
    fit_axes(&p, points);
    draw_plot(&p, points);
    bool written = fclose(p.svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
