#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include "resolvent/render.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/// Element targets; all other settings stay the same.
static const uint32_t targets[] = { 500, 1000, 2000, 4000, 8000, 16000 };
enum { target_count = sizeof targets / sizeof targets[0] };
enum { reference_target = 30000, width = 160, height = 120, samples = 16 };

static rsv_solve_desc describe_solve(uint32_t elements, bool goal, uint32_t seed)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    desc.element_target = elements;
    desc.refinements = 2;
    desc.direct_levels = 2;
    desc.rays_per_element = 1024;
    desc.seed = seed;
    if (goal) desc.goal_camera = 0;
    return desc;
}

/// The first camera's picture with all light looked up in the solution, whose error is then all there is.
static rsv_status take_picture(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_image **image, rsv_solve_report *report)
{
    rsv_light *solution = NULL;
    rsv_render_desc picture = rsv_default_render_desc();
    picture.mode = RSV_RENDER_OPERATOR;
    picture.width = width;
    picture.height = height;
    picture.samples = samples;
    rsv_status status = rsv_light_create(scene, desc, &solution);
    if (status == RSV_OK) status = rsv_render(solution, &picture, image);
    if (status == RSV_OK) *report = *rsv_light_report(solution);
    rsv_light_destroy(solution);
    return status == RSV_OK && cli_interrupted() ? RSV_ERROR_CANCELLED : status;
}

static rsv_status measure_case(
    const rsv_scene *scene, const rsv_image *reference, uint32_t target, bool goal, cJSON *cases)
{
    rsv_image *image = NULL;
    rsv_solve_report report;
    rsv_image_difference difference;
    rsv_solve_desc desc = describe_solve(target, goal, 1);
    rsv_status status = take_picture(scene, &desc, &image, &report);
    if (status == RSV_OK) status = rsv_image_compare(reference, 0, image, 0, &difference);
    if (status == RSV_OK) {
        cJSON *one = cJSON_CreateObject();
        cJSON_AddBoolToObject(one, "goal", goal);
        cJSON_AddNumberToObject(one, "target", target);
        cJSON_AddNumberToObject(
            one, "elements", (double)(report.elements + report.direct_elements));
        cJSON_AddNumberToObject(one, "unknowns", (double)report.elements);
        cJSON_AddNumberToObject(one, "median_error", difference.median_relative_error);
        cJSON_AddNumberToObject(one, "relative_mse", difference.relative_mse);
        cJSON_AddItemToArray(cases, one);
    }
    rsv_image_destroy(image);
    return status;
}

static bool is_goal(const cJSON *one) { return cJSON_IsTrue(cJSON_GetObjectItem(one, "goal")); }

/// Number of elements for which a solution without a goal has the same error: interpolated on logarithmic scales.
/// @param kind of error @return NAN outside the measured range
static double elements_without_goal(const cJSON *result, const char *kind, double error)
{
    double before[2] = { 0 };
    const cJSON *one;
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "cases"))
    {
        if (is_goal(one)) continue;
        double now[2] = { cli_json_number(one, "elements"), cli_json_number(one, kind) };
        if (before[0] > 0 && before[1] >= error && error >= now[1]) {
            double share = log(before[1] / error) / log(before[1] / now[1]);
            return before[0] * pow(now[0] / before[0], share);
        }
        before[0] = now[0], before[1] = now[1];
    }
    return NAN;
}

/// How many times fewer elements a case with a goal has than one without of the same error.
static double gain(const cJSON *result, const cJSON *one, const char *kind)
{
    return elements_without_goal(result, kind, cli_json_number(one, kind)) /
           cli_json_number(one, "elements");
}

/// Geometric mean over all cases with a goal whose error was reached without one. @return NAN if there is none
static double mean_gain(const cJSON *result, const char *kind)
{
    double sum = 0;
    int count = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "cases"))
    {
        double times = is_goal(one) ? gain(result, one, kind) : NAN;
        if (isnan(times)) continue;
        sum += log(times);
        count++;
    }
    return count > 0 ? exp(sum / count) : NAN;
}

bool cli_bench_goal(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    rsv_image *reference = NULL;
    rsv_solve_report report;
    rsv_solve_desc desc = describe_solve(reference_target, false, 2);
    cJSON *cases = cJSON_AddArrayToObject(result, "cases");
    desc.direct_levels = 4;
    rsv_status status = take_picture(scene, &desc, &reference, &report);
    for (int i = 0; i < 2 * target_count && status == RSV_OK; i++)
        status = measure_case(scene, reference, targets[i / 2], i % 2, cases);
    rsv_image_destroy(reference);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) {
        cli_report_failure(bench->session, status);
        return false;
    }
    cJSON_AddNumberToObject(result, "fewer_for_median", mean_gain(result, "median_error"));
    cJSON_AddNumberToObject(result, "fewer_for_mse", mean_gain(result, "relative_mse"));
    return true;
}

static void print_gain(double times)
{
    if (isnan(times))
        printf(" %13s", "-");
    else
        printf(" %11.2f x", times);
}

void cli_print_goal(const cJSON *result)
{
    const cJSON *one;
    printf("  %-6s %10s %10s %13s %13s %13s %13s\n", "goal", "elements", "unknowns", "median error",
        "relative MSE", "fewer for it", "fewer for it");
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "cases"))
    {
        printf("  %-6s %10.0f %10.0f %11.3f %% %13.3g", is_goal(one) ? "yes" : "no",
            cli_json_number(one, "elements"), cli_json_number(one, "unknowns"),
            100 * cli_json_number(one, "median_error"), cli_json_number(one, "relative_mse"));
        if (is_goal(one)) {
            print_gain(gain(result, one, "median_error"));
            print_gain(gain(result, one, "relative_mse"));
        }
        putchar('\n');
    }
    printf(
        "  fewer elements for the same error, geometric mean: %.2f x by the median, %.2f x by the "
        "relative MSE\n",
        mean_gain(result, "median_error"), mean_gain(result, "relative_mse"));
}

bool cli_write_goal_csv(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *csv = open_memstream(&text, &length);
    if (!csv) return false;
    fputs("scene,goal,elements,unknowns,median_error,relative_mse", csv);
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases")) fprintf(csv,
            "\n%s,%s,%.0f,%.0f,%.6g,%.6g",
            cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")), is_goal(one) ? "yes" : "no",
            cli_json_number(one, "elements"), cli_json_number(one, "unknowns"),
            cli_json_number(one, "median_error"), cli_json_number(one, "relative_mse"));
    }
    fputc('\n', csv);
    bool written = fclose(csv) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}

enum { panel_width = 440, panel_height = 360, legend_height = 40 };

static void draw_curve(const cli_plot *p, const cJSON *scene, bool goal)
{
    double before[2] = { 0 };
    const cJSON *one;
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
    {
        if (is_goal(one) != goal) continue;
        double now[2] = { cli_json_number(one, "elements"), cli_json_number(one, "median_error") };
        if (before[0] > 0) cli_plot_line(p, before, now, goal ? "goal" : "all");
        before[0] = now[0], before[1] = now[1];
    }
}

static void draw_panel(FILE *svg, const cJSON *scene, int index)
{
    double left = panel_width * index, low[2] = { INFINITY, INFINITY }, high[2] = { 0, 0 };
    const cJSON *one;
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
    {
        double value[2] = { cli_json_number(one, "elements"),
            cli_json_number(one, "median_error") };
        for (int i = 0; i < 2; i++)
            low[i] = fmin(low[i], value[i]), high[i] = fmax(high[i], value[i]);
    }
    cli_plot p = { .svg = svg,
        .x = { .from = left + 70, .to = left + panel_width - 20, .format = "%g", .unit = 1 },
        .y = { .from = legend_height + panel_height - 60,
            .to = legend_height + 30,
            .format = "%g %%",
            .unit = 0.01 } };
    cli_axis_cover(&p.x, low[0], high[0]);
    cli_axis_cover(&p.y, low[1], high[1]);
    cli_plot_grid(&p);
    draw_curve(&p, scene, false);
    draw_curve(&p, scene, true);
    fprintf(svg,
        "<text x='%.0f' y='%d' text-anchor='middle'>%s: median pixel error over elements</text>\n",
        left + 0.5 * panel_width + 25, legend_height + 20,
        cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")));
}

bool cli_write_goal_plot(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none;stroke-width:2} text{fill:#333} "
        "path.grid{stroke:#eee;stroke-width:1} path.decade{stroke:#bbb;stroke-width:1} "
        ".all{stroke:#2a5d9f} .goal{stroke:#c8401f}</style>\n"
        "<rect width='100%%' height='100%%' fill='#fff'/>\n"
        "<path d='M70 20h24' class='all'/><text x='100' y='24'>all surfaces alike</text>"
        "<path d='M240 20h24' class='goal'/><text x='270' y='24'>--goal</text>\n",
        panel_width * cJSON_GetArraySize(scenes), legend_height + panel_height);
    const cJSON *scene;
    int index = 0;
    cJSON_ArrayForEach(scene, scenes) draw_panel(svg, scene, index++);
    fputs("</svg>\n", svg);
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
