/// Time to given errors of pictures: from the file, of another view, and under other light, compared with mode
/// `reference`.
#include "judged_view.h"
#include "room_files.h"
#include "stats.h"

#include "resolvent/lightmix.h"
#include "resolvent/plan.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>

/// Relative MSEs that times are given for.
static const double wanted[] = { 0.02, 0.005, 0.001 };
enum { wanted_count = sizeof wanted / sizeof wanted[0] };

/// Camera rays per pixel of the measured pictures, up to the first with a smaller error than all targets.
static const uint32_t ladder[] = { 1, 4, 16, 64 };
enum { ladder_count = sizeof ladder / sizeof ladder[0], quality_count = 3 };

/// After the qualities: pictures that are planned for the wanted errors, solution included.
enum { PLANNED = quality_count, way_count };

typedef enum view_kind { FIRST, SECOND, RELIT, VIEWS } view_kind;

static const char *const view_names[] = { "first picture", "second view", "relit view" };

/// Pictures of one view from one solution.
typedef struct curve {
    cli_cost cost[ladder_count]; ///< of the picture alone
    double error[ladder_count];  ///< relative MSE
    size_t count;
} curve;

/// Share of a scene's time for references, and the least for a picture with more camera rays or a solution of the next
/// quality.
#define REFERENCE_SHARE 0.4
#define NEXT_PICTURE 4
/// A picture with four times the camera rays that errs by more than this part of the last: solutions err most of it.
#define STAGNANT 0.6
#define NEXT_QUALITY 3

typedef struct measurement {
    const cli_bench_task *bench;
    rsv_scene *scene;
    cli_judged_view view[2];
    cli_cost load, solve[way_count], prepare[quality_count];
    curve curve[way_count][VIEWS]; ///< of relit views: one picture at most
    double deadline;               ///< by the clock
    bool cut_short;                ///< for want of time
    cJSON *points;
} measurement;

/// Whether enough time is left for something that takes this long.
static bool has_time(measurement *m, double seconds)
{
    bool has = cli_seconds() + seconds < m->deadline;
    m->cut_short = m->cut_short || !has;
    return has;
}

// ---- measurements -------------------------------------------------------------------------------

static const char *way_name(int way) { return way == PLANNED ? "plan" : cli_quality_names[way]; }

static void describe_point(
    const measurement *m, int quality, view_kind view, uint32_t samples, const curve *c)
{
    size_t last = c->count - 1;
    cJSON *point = cJSON_CreateObject();
    cJSON_AddStringToObject(point, "quality", way_name(quality));
    cJSON_AddStringToObject(point, "view", view_names[view]);
    cJSON_AddNumberToObject(point, "spp", samples);
    cJSON_AddNumberToObject(point, "seconds", c->cost[last].seconds);
    cJSON_AddNumberToObject(point, "cpu_seconds", c->cost[last].cpu_seconds);
    cJSON_AddNumberToObject(point, "relative_mse", c->error[last]);
    if (view == RELIT)
        cJSON_AddNumberToObject(point, "prepare_cpu_seconds", m->prepare[quality].cpu_seconds);
    cJSON_AddItemToArray(m->points, point);
}

/// Whether more camera rays would hardly help.
static bool is_stagnant(const curve *c)
{
    return c->count > 1 && c->error[c->count - 1] > STAGNANT * c->error[c->count - 2];
}

/// Pictures with more and more camera rays.
static rsv_status climb(measurement *m, const rsv_light *light, int quality, view_kind view)
{
    curve *c = &m->curve[quality][view];
    rsv_status status = RSV_OK;
    double error = INFINITY;
    for (size_t k = 0; k < ladder_count && status == RSV_OK; k++) {
        if (error < wanted[wanted_count - 1] || is_stagnant(c)) break;
        if (k > 0 && !has_time(m, NEXT_PICTURE * c->cost[k - 1].seconds)) break;
        cli_cost started = cli_cost_now();
        rsv_image *image = NULL;
        status = cli_take_view(&m->view[view], light, ladder[k], &image);
        c->cost[k] = cli_cost_since(started);
        if (status == RSV_OK) status = cli_judge_view(&m->view[view], image, &error);
        rsv_image_destroy(image);
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        if (status != RSV_OK) break;
        c->error[k] = error;
        c->count++;
        describe_point(m, quality, view, ladder[k], c);
    }
    return status;
}

/// First pictures as `render --error` makes them, for each of the wanted errors.
static rsv_status plan_pictures(measurement *m)
{
    curve *c = &m->curve[PLANNED][FIRST];
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < wanted_count && status == RSV_OK; k++) {
        if (k > 0 && !has_time(m, NEXT_PICTURE * c->cost[k - 1].seconds)) break;
        rsv_plan_desc desc = rsv_default_plan_desc();
        rsv_render_desc picture = cli_describe_view(&m->view[FIRST], 1);
        rsv_picture_plan plan;
        rsv_light *light = NULL;
        rsv_image *image = NULL;
        desc.relative_error = sqrt(wanted[k]);
        cli_cost started = cli_cost_now();
        status = rsv_render_planned(m->scene, &desc, &picture, &light, &image, &plan);
        c->cost[k] = cli_cost_since(started);
        if (status == RSV_OK) status = cli_judge_view(&m->view[FIRST], image, &c->error[k]);
        rsv_image_destroy(image);
        rsv_light_destroy(light);
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        if (status != RSV_OK) break;
        c->count++;
        describe_point(m, PLANNED, FIRST, plan.samples, c);
    }
    return status;
}

/// Camera rays of the pictures that relit views are mixed from: enough for the middle one of the target errors, or the
/// most that were measured. 0 = no picture was taken.
static uint32_t mixed_samples(const measurement *m, int quality)
{
    const curve *c = &m->curve[quality][FIRST];
    size_t k = 0;
    while (k + 1 < c->count && c->error[k] > wanted[1])
        k++;
    return c->count ? ladder[k] : 0;
}

static rsv_status take_mixed(
    rsv_relighter *relighter, rsv_light_mix *mix, float factor, rsv_image **image)
{
    const rsv_light_scale scale = { rsv_relighter_source(relighter, 0).name,
        { factor, factor, factor } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = &scale, .light_count = 1 };
    rsv_status status = rsv_relighter_change(relighter, &desc);
    return status == RSV_OK ? rsv_light_mix_take(mix, image) : status;
}

/// A picture under a light that is changed, and how far the same sum is off where nothing is.
static rsv_status measure_mix(
    measurement *m, rsv_relighter *relighter, rsv_light_mix *mix, int quality)
{
    rsv_image *image[3] = { NULL };
    curve *c = &m->curve[quality][RELIT];
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_relighter_prepare(relighter);
    if (status == RSV_OK) status = take_mixed(relighter, mix, 0.5f, &image[0]);
    m->prepare[quality] = cli_cost_since(started);
    started = cli_cost_now();
    if (status == RSV_OK) status = take_mixed(relighter, mix, 0.25f, &image[1]);
    c->cost[0] = cli_cost_since(started);
    if (status == RSV_OK) status = take_mixed(relighter, mix, 1, &image[2]);
    if (status == RSV_OK) status = cli_judge_view(&m->view[FIRST], image[2], &c->error[0]);
    c->count = status == RSV_OK;
    for (int k = 0; k < 3; k++)
        rsv_image_destroy(image[k]);
    return status;
}

static rsv_status relight(measurement *m, rsv_light *light, int quality)
{
    rsv_relighter *relighter = NULL;
    rsv_light_mix *mix = NULL;
    uint32_t samples = mixed_samples(m, quality);
    rsv_render_desc desc = cli_describe_view(&m->view[FIRST], samples);
    const curve *first = &m->curve[quality][FIRST];
    if (!samples || !has_time(m, 2 * first->cost[first->count - 1].seconds)) return RSV_OK;
    rsv_status status = rsv_relighter_create(light, &relighter);
    bool lit = status == RSV_OK && rsv_relighter_source_count(relighter) > 0;
    if (lit) status = rsv_light_mix_create(relighter, &desc, &mix);
    if (lit && status == RSV_OK) status = measure_mix(m, relighter, mix, quality);
    if (lit && status == RSV_OK)
        describe_point(m, quality, RELIT, samples, &m->curve[quality][RELIT]);
    rsv_light_mix_destroy(mix);
    rsv_relighter_destroy(relighter);
    return status;
}

static rsv_status measure_quality(measurement *m, int quality)
{
    rsv_solve_desc desc = cli_bench_solve_desc(m->bench, quality);
    rsv_light *light = NULL;
    desc.direct_level = false;
    if (quality > 0 && !has_time(m, NEXT_QUALITY * m->solve[quality - 1].seconds)) return RSV_OK;
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_light_create(m->scene, &desc, &light);
    m->solve[quality] = cli_cost_since(started);
    if (status == RSV_OK) status = climb(m, light, quality, FIRST);
    if (status == RSV_OK) status = climb(m, light, quality, SECOND);
    if (status == RSV_OK) status = relight(m, light, quality); // changes the light
    rsv_light_destroy(light);
    return status;
}

// ---- derived figures ----------------------------------------------------------------------------

/// Logarithmic between neighbouring pictures; more camera rays than were measured are not guessed at.
static cli_cost cost_of_error(const curve *c, double error)
{
    for (size_t k = 0; k < c->count; k++) {
        if (!(c->error[k] <= error)) continue;
        if (k == 0) return c->cost[0];
        double from = c->error[k - 1], to = fmax(c->error[k], 1e-9);
        double t = from > to ? log(from / error) / log(from / to) : 1;
        return (cli_cost){
            c->cost[k - 1].seconds * pow(c->cost[k].seconds / c->cost[k - 1].seconds, t),
            c->cost[k - 1].cpu_seconds * pow(c->cost[k].cpu_seconds / c->cost[k - 1].cpu_seconds, t)
        };
    }
    return (cli_cost){ INFINITY, INFINITY };
}

static cli_cost add(cli_cost a, cli_cost b)
{
    return (cli_cost){ a.seconds + b.seconds, a.cpu_seconds + b.cpu_seconds };
}

/// Total cost of a picture of known error.
static cli_cost cost_of(const measurement *m, int quality, view_kind view, double error)
{
    cli_cost picture = cost_of_error(&m->curve[quality][view], error);
    return view == FIRST ? add(picture, add(m->load, m->solve[quality])) : picture;
}

/// How an error is reached soonest.
static int best_way(const measurement *m, view_kind view, double error)
{
    int best = PLANNED;
    for (int q = 0; q <= m->bench->quality; q++)
        if (cost_of(m, q, view, error).cpu_seconds < cost_of(m, best, view, error).cpu_seconds)
            best = q;
    return best;
}

/// An error that no picture reaches has no numbers.
static cJSON *describe_time(const measurement *m, view_kind view, double error)
{
    int best = best_way(m, view, error);
    cJSON *time = cJSON_CreateObject();
    cli_cost ours = cost_of(m, best, view, error);
    double reference = cli_reference_seconds(&m->view[view == SECOND ? SECOND : FIRST], error);
    if (view == FIRST) reference += m->load.cpu_seconds;
    bool reached = isfinite(ours.cpu_seconds);
    cJSON_AddStringToObject(time, "view", view_names[view]);
    cJSON_AddNumberToObject(time, "relative_mse", error);
    if (reached) cJSON_AddStringToObject(time, "quality", way_name(best));
    cJSON_AddNumberToObject(time, "seconds", reached ? ours.seconds : NAN);
    cJSON_AddNumberToObject(time, "cpu_seconds", reached ? ours.cpu_seconds : NAN);
    cJSON_AddNumberToObject(time, "reference_cpu_seconds", reference);
    cJSON_AddNumberToObject(time, "factor", reached ? reference / ours.cpu_seconds : NAN);
    return time;
}

static rsv_status measure(measurement *m, const char *name, cJSON *result)
{
    double seconds = REFERENCE_SHARE * (m->deadline - cli_seconds());
    rsv_status status = cli_judged_views_create(m->bench, m->scene, name, seconds, m->view);
    m->points = cJSON_AddArrayToObject(result, "points");
    if (status == RSV_OK) status = plan_pictures(m);
    for (int q = 0; q <= m->bench->quality && status == RSV_OK; q++)
        status = measure_quality(m, q);
    if (status != RSV_OK) return status;
    cJSON_AddNumberToObject(result, "reference_spp", m->view[FIRST].samples);
    cJSON_AddBoolToObject(result, "cut_short", m->cut_short);
    cJSON *times = cJSON_AddArrayToObject(result, "times");
    for (int view = FIRST; view < VIEWS; view++)
        for (size_t k = 0; k < wanted_count; k++)
            cJSON_AddItemToArray(times, describe_time(m, (view_kind)view, wanted[k]));
    return RSV_OK;
}

bool cli_bench_pictures(const cli_bench_task *bench, cJSON *result)
{
    cli_room_files room;
    measurement m = { .bench = bench, .deadline = cli_seconds() + (double)bench->max_seconds };
    if (!cli_find_room(bench, "pictures", &room)) return false;
    if (cli_room_is_missing(&room, result)) return true;
    cli_environment environment = bench->environment;
    if (room.environment[0]) environment.path = room.environment;
    cli_cost started = cli_cost_now();
    m.scene = cli_open_scene(bench->session, room.scene, &environment);
    m.load = cli_cost_since(started);
    if (!m.scene) return false;
    cJSON_AddNumberToObject(result, "load_cpu_seconds", m.load.cpu_seconds);
    rsv_status status = measure(&m, room.name, result);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    cli_judged_views_destroy(m.view);
    rsv_scene_destroy(m.scene);
    return status == RSV_OK;
}

// ---- output -------------------------------------------------------------------------------------

static void print_number(const char *format, double value)
{
    if (isfinite(value))
        printf(format, value);
    else
        printf(" - |");
}

void cli_print_pictures(const cJSON *result)
{
    const cJSON *skipped = cJSON_GetObjectItem(result, "skipped"), *point;
    if (skipped) {
        printf("  skipped: %s\n", cJSON_GetStringValue(skipped));
        return;
    }
    if (cJSON_IsTrue(cJSON_GetObjectItem(result, "cut_short")))
        puts("  cut short by --max-time: what is missing below would have taken longer");
    cJSON_ArrayForEach(point, cJSON_GetObjectItem(result, "points"))
        printf("  %-13s %-6s %3.0f spp: %.3g s by the clock, %.3g s of processors, relative MSE "
               "%.2g\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(point, "view")),
            cJSON_GetStringValue(cJSON_GetObjectItem(point, "quality")),
            cli_json_number(point, "spp"), cli_json_number(point, "seconds"),
            cli_json_number(point, "cpu_seconds"), cli_json_number(point, "relative_mse"));
}

/// A table in Markdown, for docs/benchmarks.md.
void cli_print_pictures_summary(const cJSON *scenes)
{
    const cJSON *s, *time;
    puts("\n| scene | view | relative MSE | plan or quality | clock, s | processors, s | mode "
         "reference, s | times as fast |\n|---|---|---|---|---|---|---|---|");
    cJSON_ArrayForEach(s, scenes)
    {
        cJSON_ArrayForEach(time, cJSON_GetObjectItem(s, "times"))
        {
            const char *quality = cJSON_GetStringValue(cJSON_GetObjectItem(time, "quality"));
            printf("| %s | %s | %g | %s |", cJSON_GetStringValue(cJSON_GetObjectItem(s, "scene")),
                cJSON_GetStringValue(cJSON_GetObjectItem(time, "view")),
                cli_json_number(time, "relative_mse"), quality ? quality : "-");
            print_number(" %.3g |", cli_json_number(time, "seconds"));
            print_number(" %.3g |", cli_json_number(time, "cpu_seconds"));
            print_number(" %.3g |", cli_json_number(time, "reference_cpu_seconds"));
            print_number(" %.3g |", cli_json_number(time, "factor"));
            puts("");
        }
    }
}

static cJSON *flatten(const cJSON *scenes)
{
    const cJSON *s, *time;
    cJSON *rows = cJSON_CreateArray();
    cJSON_ArrayForEach(s, scenes)
    {
        const char *scene = cJSON_GetStringValue(cJSON_GetObjectItem(s, "scene"));
        cJSON_ArrayForEach(time, cJSON_GetObjectItem(s, "times"))
        {
            char name[160];
            snprintf(name, sizeof name, "%s: %s", scene,
                cJSON_GetStringValue(cJSON_GetObjectItem(time, "view")));
            cJSON *row = cJSON_Duplicate(time, true);
            cJSON_AddStringToObject(row, "scene", name);
            cJSON_AddItemToArray(rows, row);
        }
    }
    return rows;
}

bool cli_write_pictures_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "relative_mse", "seconds", "cpu_seconds",
        "reference_cpu_seconds", "factor" };
    cJSON *rows = flatten(scenes);
    bool written = cli_write_columns(path, rows, columns, sizeof columns / sizeof columns[0]);
    cJSON_Delete(rows);
    return written;
}
