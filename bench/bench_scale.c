#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include "resolvent/solve.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

/// Squares of terraces measure 25 cm: elements are meant to be eight of them apart, before pilots refine them.
#define TRIANGLES_PER_ELEMENT 128

static double processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/// Of the program so far: scenes come by size.
static double peak_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * (double)usage.ru_maxrss;
}

static void add_numbers(
    cJSON *result, size_t triangles, const rsv_solve_report *report, const double seconds[2])
{
    double elements = (double)report->elements;
    cJSON_AddNumberToObject(result, "triangles", (double)triangles);
    cJSON_AddNumberToObject(result, "elements", elements);
    cJSON_AddNumberToObject(result, "rows", (double)report->rows);
    cJSON_AddNumberToObject(result, "rays", (double)report->rays);
    cJSON_AddNumberToObject(result, "entries_per_element", (double)report->entries / elements);
    cJSON_AddNumberToObject(result, "bytes_per_element", (double)report->bytes / elements);
    cJSON_AddNumberToObject(result, "operator_bytes", (double)report->bytes);
    cJSON_AddNumberToObject(result, "peak_rss_bytes", peak_bytes());
    cJSON_AddNumberToObject(result, "seconds", seconds[0]);
    cJSON_AddNumberToObject(result, "processor_seconds", seconds[1]);
    cJSON_AddNumberToObject(result, "assemble_seconds", report->time_assemble);
    cJSON_AddNumberToObject(result, "solve_seconds", report->time_solve);
    cJSON_AddNumberToObject(result, "assemble_critical", report->critical_assemble);
    cJSON_AddNumberToObject(result, "solve_critical", report->critical_solve);
}

bool cli_bench_scale(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    size_t triangles = rsv_scene_get_view(scene)->triangle_count;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    if (strncmp(bench->scene, "terraces", strlen("terraces")) == 0) {
        desc.direct_level = false;
        desc.element_target = (uint32_t)(triangles / TRIANGLES_PER_ELEMENT);
    }
    rsv_light *solution = NULL;
    double started = cli_seconds(), worked = processor_seconds();
    rsv_status status = rsv_light_create(scene, &desc, &solution);
    const double seconds[2] = { cli_seconds() - started, processor_seconds() - worked };
    if (status == RSV_OK)
        add_numbers(result, triangles, rsv_light_report(solution), seconds);
    else
        cli_report_failure(bench->session, status);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    return status == RSV_OK;
}

void cli_print_scale(const cJSON *result)
{
    printf("  %.0f triangles, %.0f elements, %.0f rows\n", cli_json_number(result, "triangles"),
        cli_json_number(result, "elements"), cli_json_number(result, "rows"));
    printf("  %.1f entries and %.0f bytes per element, %.2f GB at the peak\n",
        cli_json_number(result, "entries_per_element"),
        cli_json_number(result, "bytes_per_element"),
        1e-9 * cli_json_number(result, "peak_rss_bytes"));
    printf("  %.2f s, %.2f s of processors\n", cli_json_number(result, "seconds"),
        cli_json_number(result, "processor_seconds"));
}

/// b of y = a n^b, by least squares over the scenes.
static double exponent(const cJSON *scenes, const char *name)
{
    double count = 0, x = 0, y = 0, xx = 0, xy = 0;
    const cJSON *scene;
    cJSON_ArrayForEach(scene, scenes)
    {
        double n = log(cli_json_number(scene, "triangles"));
        double value = log(cli_json_number(scene, name));
        count++, x += n, y += value, xx += n * n, xy += n * value;
    }
    return (count * xy - x * y) / (count * xx - x * x);
}

void cli_print_scale_summary(const cJSON *scenes)
{
    if (cJSON_GetArraySize(scenes) < 2) return;
    printf(
        "per triangle: time grows with exponent %.3f, memory of elements and operator with %.3f\n",
        exponent(scenes, "processor_seconds"), exponent(scenes, "operator_bytes"));
}

bool cli_write_scale_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "triangles", "elements", "rows", "rays",
        "entries_per_element", "bytes_per_element", "operator_bytes", "peak_rss_bytes", "seconds",
        "processor_seconds", "solve_seconds" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}

enum { plot_width = 760, plot_height = 340 };

/// One quantity over the number of triangles, with the line of proportional growth through its first point.
static void draw_curve(FILE *svg, const cJSON *scenes, const char *name, cli_axis x, cli_axis y)
{
    const cJSON *scene, *first = cJSON_GetArrayItem(scenes, 0), *before = NULL;
    cli_plot p = { svg, x, y };
    double last = cli_json_number(cJSON_GetArrayItem(scenes, cJSON_GetArraySize(scenes) - 1), name);
    double n = cli_json_number(first, "triangles"), start = cli_json_number(first, name);
    cli_axis_cover(&p.x, n, 1.01 * p.x.high);
    cli_axis_cover(&p.y, start, 1.01 * last);
    cli_plot_grid(&p);
    double reach = fmin(p.x.high / n, p.y.high / start);
    cli_plot_line(&p, (double[]){ n, start }, (double[]){ n * reach, start * reach }, "linear");
    cJSON_ArrayForEach(scene, scenes)
    {
        double at[2] = { cli_json_number(scene, "triangles"), cli_json_number(scene, name) };
        fprintf(svg, "<circle cx='%.1f' cy='%.1f' r='4'/>\n", cli_axis_place(&p.x, at[0]),
            cli_axis_place(&p.y, at[1]));
        if (before)
            cli_plot_line(&p,
                (double[]){ cli_json_number(before, "triangles"), cli_json_number(before, name) },
                at, "measured");
        before = scene;
    }
}

bool cli_write_scale_plot(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    int last = cJSON_GetArraySize(scenes) - 1;
    double most = cli_json_number(cJSON_GetArrayItem(scenes, last), "triangles");
    cli_axis x = { .high = most, .format = "%g", .unit = 1 };
    cli_axis y = { .from = plot_height - 50, .to = 40, .format = "%g s", .unit = 1 };
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none} text{fill:#333} circle{fill:#2a5d9f} "
        ".grid{stroke:#eee} .decade{stroke:#bbb} .linear{stroke:#999;stroke-dasharray:5 4} "
        ".measured{stroke:#2a5d9f;stroke-width:2}</style>\n"
        "<rect width='100%%' height='100%%' fill='#fff'/>\n"
        "<text x='70' y='22'>processor time of a solution</text>\n"
        "<text x='%d' y='22'>memory of elements and operator</text>\n"
        "<text x='%d' y='%d' text-anchor='middle'>triangles (dashed: proportional)</text>\n",
        plot_width, plot_height, plot_width / 2 + 70, plot_width / 2, plot_height - 8);
    x.from = 70, x.to = plot_width / 2 - 20;
    draw_curve(svg, scenes, "processor_seconds", x, y);
    x.from = plot_width / 2 + 70, x.to = plot_width - 20;
    y.format = "%g MB", y.unit = 1e6;
    draw_curve(svg, scenes, "operator_bytes", x, y);
    fprintf(svg, "</svg>\n");
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
