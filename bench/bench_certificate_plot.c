#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

bool cli_write_certificate_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "seed", "elements", "irradiance_rms", "true_error",
        "true_error_low", "true_error_high", "residual_rms", "error_estimate", "error_bound" };
    enum { column_count = sizeof columns / sizeof columns[0] };
    char *text = NULL;
    size_t length = 0;
    FILE *csv = open_memstream(&text, &length);
    if (!csv) return false;
    fputs("scene,quality", csv);
    for (size_t i = 0; i < column_count; i++)
        fprintf(csv, ",%s", columns[i]);
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
        {
            fprintf(csv, "\n%s,%s", cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")),
                cJSON_GetStringValue(cJSON_GetObjectItem(one, "quality")));
            for (size_t i = 0; i < column_count; i++)
                fprintf(csv, ",%.6g", cli_json_number(one, columns[i]));
        }
    }
    fputc('\n', csv);
    bool written = fclose(csv) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}

enum { plot_width = 640, plot_height = 480 };

/// A number of a case, relative to the irradiance.
static double relative(const cJSON *one, const char *name)
{
    return cli_json_number(one, name) / cli_json_number(one, "irradiance_rms");
}

static void fit_axes(cli_plot *p, const cJSON *scenes)
{
    double low = INFINITY, high = 0, highest = 0;
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
        {
            double error = relative(one, "true_error"), bound = relative(one, "error_bound");
            if (error > 0) low = fmin(low, error);
            high = fmax(high, error);
            if (isfinite(bound)) highest = fmax(highest, bound);
        }
    }
    p->x = (cli_axis){ .from = 70, .to = plot_width - 20, .format = "%g %%", .unit = 0.01 };
    p->y = (cli_axis){ .from = plot_height - 60, .to = 40, .format = "%g %%", .unit = 0.01 };
    cli_axis_cover(&p->x, low, high);
    cli_axis_cover(&p->y, low, highest);
}

static void draw_points(const cli_plot *p, const cJSON *scenes, const char *name)
{
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
        {
            double error = relative(one, "true_error"), value = relative(one, name);
            if (error < p->x.low || value < p->y.low || !isfinite(value)) continue;
            fprintf(p->svg, "<circle cx='%.1f' cy='%.1f' r='3.5' class='%s'/>\n",
                cli_axis_place(&p->x, error), cli_axis_place(&p->y, value), name);
        }
    }
}

static void draw_plot(const cli_plot *p, const cJSON *scenes)
{
    fprintf(p->svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none} text{fill:#333} .grid{stroke:#eee} "
        ".decade{stroke:#bbb} .truth{stroke:#222;stroke-width:1.5} .error_bound{fill:#2a5d9f} "
        ".error_estimate{fill:#c8401f}</style>\n<rect width='100%%' height='100%%' fill='#fff'/>\n"
        "<circle cx='90' cy='20' r='4' class='error_bound'/><text x='100' y='24'>bound</text>"
        "<circle cx='180' cy='20' r='4' class='error_estimate'/><text x='190' y='24'>estimate"
        "</text><path d='M280 20h24' class='truth'/><text x='310' y='24'>the truth</text>\n",
        plot_width, plot_height);
    cli_plot_grid(p);
    double low = fmax(p->x.low, p->y.low), high = fmin(p->x.high, p->y.high);
    cli_plot_line(p, (double[]){ low, low }, (double[]){ high, high }, "truth");
    draw_points(p, scenes, "error_bound");
    draw_points(p, scenes, "error_estimate");
    fprintf(p->svg,
        "<text x='%d' y='%d' text-anchor='middle'>true error of irradiance, relative RMS</text>\n"
        "</svg>\n",
        plot_width / 2 + 25, plot_height - 15);
}

bool cli_write_certificate_plot(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    cli_plot plot = { .svg = open_memstream(&text, &length) };
    if (!plot.svg) return false;
    fit_axes(&plot, scenes);
    draw_plot(&plot, scenes);
    bool written = fclose(plot.svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
