#include "benchmarks.h"
#include "output_file.h"
#include "plot.h"

#include "resolvent/render.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// The median error at which rays are compared.
static const double aim = 0.01;

/// The contestants: one level at the finest spacing of direct light, one level with as many elements as direct light
/// has but evenly spread, and two levels.
typedef enum curve { FINE_SPACING, AS_MANY, TWO_LEVELS, CURVES } curve;

static const char *const curve_names[] = { "one, at the fine spacing", "one, as many elements",
    "two" };

enum { side = 128, samples = 4 };
enum { fewest_rays = 64, most_rays = 1024, fewest_elements = 250 };
/// The reference has this many times the element target and the rays of the quality.
enum { reference_factor = 2, reference_seed = 101 };

/// Luminance of all orders of light from the first reflection on.
static void add_indirect(const rsv_image *image, double share, double *sum)
{
    uint32_t first = rsv_image_find_layer(image, "bounce1");
    for (uint32_t layer = first; layer < rsv_image_layer_count(image); layer++) {
        const rsv_rgb *pixel = rsv_image_const_pixels(image, layer);
        for (size_t i = 0; i < side * side; i++)
            sum[i] += share * (0.2126 * (double)pixel[i].r + 0.7152 * (double)pixel[i].g +
                                  0.0722 * (double)pixel[i].b);
    }
}

/// The indirect light of the first camera's picture, looked up in a solution. @param indirect [side * side], added to
static rsv_status take_picture(const rsv_scene *scene, const rsv_solve_desc *desc, double share,
    double *indirect, rsv_solve_report *report)
{
    rsv_light *solution = NULL;
    rsv_image *image = NULL;
    rsv_render_desc picture = rsv_default_render_desc();
    picture.mode = RSV_RENDER_OPERATOR;
    picture.width = picture.height = side;
    picture.samples = samples;
    picture.layers = true;
    rsv_status status = rsv_light_create(scene, desc, &solution);
    if (status == RSV_OK) status = rsv_render(solution, &picture, &image);
    if (status == RSV_OK) {
        add_indirect(image, share, indirect);
        *report = *rsv_light_report(solution);
    }
    rsv_image_destroy(image);
    rsv_light_destroy(solution);
    return status == RSV_OK && cli_interrupted() ? RSV_ERROR_CANCELLED : status;
}

/// Median over the pixels of the relative error, and its root mean square relative to the picture's.
typedef struct indirect_error {
    double median, rms;
} indirect_error;

/// The mean of two solutions. Half their difference is distributed like the error of that mean.
typedef struct judge {
    double mean[side * side], difference[side * side];
    indirect_error own;
} judge;

/// @param difference from the reference; used up
static indirect_error error_of(const double *reference, double *difference)
{
    double sum = 0, square = 0;
    size_t lit = 0;
    for (size_t i = 0; i < side * side; i++) {
        sum += difference[i] * difference[i];
        square += reference[i] * reference[i];
        if (reference[i] > 0) difference[lit++] = fabs(difference[i]) / reference[i];
    }
    return (indirect_error){ lit ? cli_median(difference, lit) : 0, sqrt(sum / square) };
}

/// The error without the reference's own share: independent errors add in squares.
static double corrected(double error, double own)
{
    return sqrt(fmax(error * error - own * own, 0));
}

static rsv_status make_judge(const rsv_scene *scene, const rsv_solve_desc *quality, judge *j)
{
    rsv_solve_report report;
    rsv_solve_desc desc = *quality;
    desc.element_target *= reference_factor;
    desc.rays_per_element *= reference_factor;
    desc.seed = reference_seed;
    *j = (judge){ 0 };
    rsv_status status = take_picture(scene, &desc, 0.5, j->difference, &report);
    desc.seed++;
    if (status == RSV_OK) status = take_picture(scene, &desc, 0.5, j->mean, &report);
    for (size_t i = 0; i < side * side; i++) {
        double first = j->difference[i], second = j->mean[i];
        j->difference[i] = first - second;
        j->mean[i] = first + second;
    }
    j->own = error_of(j->mean, j->difference);
    return status;
}

/// Solves once and notes rays and errors, the reference's own taken off. @param median out
static rsv_status measure_case(const rsv_scene *scene, const rsv_solve_desc *desc, const judge *j,
    curve of, cJSON *cases, double *median)
{
    double *difference = calloc(side * side, sizeof *difference);
    if (!difference) return RSV_ERROR_MEMORY;
    rsv_solve_report report;
    for (size_t i = 0; i < side * side; i++)
        difference[i] = -j->mean[i];
    rsv_status status = take_picture(scene, desc, 1, difference, &report);
    indirect_error error = error_of(j->mean, difference);
    free(difference);
    if (status != RSV_OK) return status;
    *median = corrected(error.median, j->own.median);
    cJSON *one = cJSON_CreateObject();
    cJSON_AddNumberToObject(one, "curve", of);
    cJSON_AddNumberToObject(one, "rows", (double)report.rows);
    cJSON_AddNumberToObject(one, "rays_per_row", desc->rays_per_element);
    cJSON_AddNumberToObject(one, "rays", (double)report.rays);
    cJSON_AddNumberToObject(one, "median_error", *median);
    cJSON_AddNumberToObject(one, "rms_error", corrected(error.rms, j->own.rms));
    cJSON_AddItemToArray(cases, one);
    return RSV_OK;
}

/// One level: more rays a row until the error is small enough.
static rsv_status measure_one(const rsv_scene *scene, const rsv_solve_desc *quality,
    uint32_t elements, const judge *j, curve of, cJSON *cases)
{
    double median = INFINITY;
    rsv_status status = RSV_OK;
    rsv_solve_desc desc = *quality;
    desc.element_target = elements;
    desc.refinements = 0;
    for (uint32_t rays = fewest_rays; status == RSV_OK && median > aim && rays <= most_rays;
         rays *= 2) {
        desc.rays_per_element = rays;
        status = measure_case(scene, &desc, j, of, cases, &median);
    }
    return status;
}

/// Two levels: indirect light on elements of its own, refined by pilots; more of them until the error is small enough.
static rsv_status measure_two(
    const rsv_scene *scene, const rsv_solve_desc *quality, const judge *j, cJSON *cases)
{
    double median = INFINITY;
    rsv_status status = RSV_OK;
    rsv_solve_desc desc = *quality;
    for (uint32_t elements = fewest_elements;
         status == RSV_OK && median > aim && elements <= 4 * quality->element_target;
         elements *= 2) {
        desc.element_target = elements;
        status = measure_case(scene, &desc, j, TWO_LEVELS, cases, &median);
    }
    return status;
}

/// Rays for the error aimed at, between the two nearest cases on logarithmic scales; NAN if it was not reached. Where
/// the first case is better already, its rays: there are no fewer.
static double rays_at_aim(const cJSON *cases, curve of)
{
    double before[2] = { 0 };
    const cJSON *one;
    cJSON_ArrayForEach(one, cases)
    {
        if (cli_json_number(one, "curve") != of) continue;
        double now[2] = { cli_json_number(one, "rays"), cli_json_number(one, "median_error") };
        if (now[1] <= aim) {
            if (!(before[0] > 0 && now[1] > 0)) return now[0];
            double share = log(before[1] / aim) / log(before[1] / now[1]);
            return before[0] * pow(now[0] / before[0], share);
        }
        before[0] = now[0], before[1] = now[1];
    }
    return NAN;
}

static rsv_status measure_all(
    const cli_bench_task *bench, const rsv_scene *scene, judge *j, cJSON *result)
{
    rsv_solve_desc quality = rsv_default_solve_desc((rsv_quality)bench->quality);
    if (bench->max_elements && bench->max_elements < quality.element_target)
        quality.element_target = bench->max_elements;
    rsv_solve_report report = { 0 };
    cJSON *cases = cJSON_AddArrayToObject(result, "cases");
    rsv_status status = take_picture(scene, &quality, 1, j->mean, &report);
    size_t many = report.direct_elements > report.rows ? report.direct_elements : report.rows;
    uint32_t fine = quality.element_target << (2 * quality.direct_levels);
    quality.direct_level = false; // from here on only indirect light
    if (status == RSV_OK) status = make_judge(scene, &quality, j);
    if (status == RSV_OK) status = measure_one(scene, &quality, fine, j, FINE_SPACING, cases);
    if (status == RSV_OK) status = measure_one(scene, &quality, (uint32_t)many, j, AS_MANY, cases);
    if (status == RSV_OK) status = measure_two(scene, &quality, j, cases);
    cJSON_AddNumberToObject(result, "own_median_error", j->own.median);
    cJSON_AddNumberToObject(result, "own_rms_error", j->own.rms);
    cJSON *rays = cJSON_AddArrayToObject(result, "rays_at_aim");
    for (int of = 0; of < CURVES; of++)
        cJSON_AddItemToArray(rays, cJSON_CreateNumber(rays_at_aim(cases, (curve)of)));
    return status;
}

bool cli_bench_levels(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    judge *j = calloc(1, sizeof *j);
    rsv_status status = j ? measure_all(bench, scene, j, result) : RSV_ERROR_MEMORY;
    free(j);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_levels(const cJSON *result)
{
    const cJSON *one, *rays = cJSON_GetObjectItem(result, "rays_at_aim");
    printf("  %-24s %9s %10s %10s %12s %10s\n", "levels", "rows", "rays a row", "rays",
        "median error", "RMS error");
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(result, "cases"))
        printf("  %-24s %9.0f %10.0f %8.2f M %10.3f %% %8.3f %%\n",
            curve_names[(int)cli_json_number(one, "curve")], cli_json_number(one, "rows"),
            cli_json_number(one, "rays_per_row"), 1e-6 * cli_json_number(one, "rays"),
            100 * cli_json_number(one, "median_error"), 100 * cli_json_number(one, "rms_error"));
    printf("  the reference's own error: median %.3f %%, RMS %.3f %%\n",
        100 * cli_json_number(result, "own_median_error"),
        100 * cli_json_number(result, "own_rms_error"));
    double two = cJSON_GetNumberValue(cJSON_GetArrayItem(rays, TWO_LEVELS));
    for (int of = 0; of < CURVES; of++) {
        double own = cJSON_GetNumberValue(cJSON_GetArrayItem(rays, of));
        printf("  rays for a median error of %g %%, levels: %s: %.2f M, %.1f times those of two\n",
            100 * aim, curve_names[of], 1e-6 * own, own / two);
    }
}

/// The cases of all scenes, each with its scene's name.
static cJSON *list_cases(const cJSON *scenes)
{
    cJSON *list = cJSON_CreateArray();
    const cJSON *scene, *one;
    cJSON_ArrayForEach(scene, scenes)
    {
        cJSON_ArrayForEach(one, cJSON_GetObjectItem(scene, "cases"))
        {
            cJSON *row = cJSON_Duplicate(one, true);
            cJSON_AddStringToObject(
                row, "scene", cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")));
            cJSON_AddItemToArray(list, row);
        }
    }
    return list;
}

bool cli_write_levels_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "curve", "rows", "rays_per_row", "rays", "median_error",
        "rms_error" };
    cJSON *rows = list_cases(scenes);
    bool written = cli_write_columns(path, rows, columns, sizeof columns / sizeof columns[0]);
    cJSON_Delete(rows);
    return written;
}

enum { plot_width = 560, plot_height = 400 };

static const char *const styles[] = { "fine", "many", "two" };
static const double least_error = 1e-4; ///< that is drawn

static void draw_curve(const cli_plot *p, const cJSON *cases, curve of)
{
    double before[2] = { 0 };
    const cJSON *one;
    cJSON_ArrayForEach(one, cases)
    {
        if (cli_json_number(one, "curve") != of) continue;
        double now[2] = { cli_json_number(one, "rays"), cli_json_number(one, "median_error") };
        if (before[0] > 0) cli_plot_line(p, before, now, styles[of]);
        fprintf(p->svg, "<circle cx='%.1f' cy='%.1f' r='3.5' class='%s'/>\n",
            cli_axis_place(&p->x, now[0]), cli_axis_place(&p->y, fmax(now[1], least_error)),
            styles[of]);
        before[0] = now[0], before[1] = now[1];
    }
}

bool cli_write_levels_plot(const char *path, const cJSON *scenes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    const cJSON *scene = cJSON_GetArrayItem(scenes, 0), *one;
    const cJSON *cases = cJSON_GetObjectItem(scene, "cases");
    double low[2] = { INFINITY, aim }, high[2] = { 0, aim };
    cJSON_ArrayForEach(one, cases)
    {
        double value[2] = { cli_json_number(one, "rays"), cli_json_number(one, "median_error") };
        for (int i = 0; i < 2; i++)
            low[i] = fmin(low[i], value[i]), high[i] = fmax(high[i], value[i]);
    }
    cli_plot p = { .svg = svg,
        .x = { .from = 70, .to = plot_width - 20, .format = "%g M", .unit = 1e6 },
        .y = { .from = plot_height - 50, .to = 50, .format = "%g %%", .unit = 0.01 } };
    cli_axis_cover(&p.x, low[0], high[0]);
    cli_axis_cover(&p.y, fmax(low[1], least_error), high[1]);
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' "
        "font-size='12'>\n<style>path{fill:none;stroke-width:2} text{fill:#333} "
        "path.grid{stroke:#eee;stroke-width:1} path.decade{stroke:#bbb;stroke-width:1} "
        "circle{fill:#fff;stroke-width:2} "
        ".fine{stroke:#2a5d9f} .many{stroke:#6fa8dc} .two{stroke:#c8401f}</style>\n"
        "<rect width='100%%' height='100%%' fill='#fff'/>\n"
        "<path d='M70 20h20' class='fine'/><text x='95' y='24'>one level, fine spacing</text>"
        "<path d='M245 20h20' class='many'/><text x='270' y='24'>one level, as many elements</text>"
        "<path d='M450 20h20' class='two'/><text x='475' y='24'>two levels</text>\n"
        "<text x='%d' y='%d' text-anchor='middle'>%s: median error of indirect light over "
        "rays</text>\n",
        plot_width, plot_height, plot_width / 2 + 25, plot_height - 12,
        cJSON_GetStringValue(cJSON_GetObjectItem(scene, "scene")));
    cli_plot_grid(&p);
    for (int of = 0; of < CURVES; of++)
        draw_curve(&p, cases, (curve)of);
    fputs("</svg>\n", svg);
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
