/// Time to given errors of pictures: from the file, of another view, and under other light, beside mode `reference`.
#include "judged_view.h"
#include "room_files.h"
#include "stats.h"

#include "resolvent/relight.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>

/// Relative MSEs that times are given for.
static const double wanted[] = { 0.02, 0.005, 0.001 };
enum { wanted_count = sizeof wanted / sizeof wanted[0] };

/// Camera rays per pixel of the pictures that are measured, up to the first that errs less than all that is wanted.
static const uint32_t ladder[] = { 1, 4, 16, 64 };
enum { ladder_count = sizeof ladder / sizeof ladder[0], quality_count = 3 };

typedef enum view_kind { FIRST, SECOND, RELIT, VIEWS } view_kind;

static const char *const view_names[] = { "first picture", "second view", "relit view" };

/// Pictures of one view from one solution.
typedef struct curve {
    cli_cost cost[ladder_count]; ///< of the picture alone
    double error[ladder_count];  ///< relative MSE
    size_t count;
} curve;

typedef struct measurement {
    const cli_bench_task *bench;
    rsv_scene *scene;
    cli_judged_view view[2];
    cli_cost load, solve[quality_count], relight[quality_count];
    curve curve[quality_count][2];
    cJSON *points;
} measurement;

// ---- what is measured ---------------------------------------------------------------------------

static void describe_point(
    const measurement *m, int quality, view_kind view, uint32_t samples, const curve *c)
{
    size_t last = c->count - 1;
    cJSON *point = cJSON_CreateObject();
    cJSON_AddStringToObject(point, "quality", cli_quality_names[quality]);
    cJSON_AddStringToObject(point, "view", view_names[view]);
    cJSON_AddNumberToObject(point, "spp", samples);
    cJSON_AddNumberToObject(point, "seconds", c->cost[last].seconds);
    cJSON_AddNumberToObject(point, "cpu_seconds", c->cost[last].cpu_seconds);
    cJSON_AddNumberToObject(point, "relative_mse", c->error[last]);
    cJSON_AddItemToArray(m->points, point);
}

/// Pictures with more and more camera rays.
static rsv_status climb(measurement *m, const rsv_light *light, int quality, view_kind view)
{
    curve *c = &m->curve[quality][view];
    rsv_status status = RSV_OK;
    double error = INFINITY;
    for (size_t k = 0; k < ladder_count && status == RSV_OK; k++) {
        if (error < wanted[wanted_count - 1]) break;
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

/// A change of strength after the preparations that a sequence of changes makes once.
static rsv_status relight(measurement *m, rsv_light *light, int quality)
{
    rsv_relighter *relighter = NULL;
    rsv_status status = rsv_relighter_create(light, &relighter);
    m->relight[quality] = (cli_cost){ NAN, NAN };
    if (status == RSV_OK && rsv_relighter_source_count(relighter) > 0) {
        const rsv_light_scale scale = { rsv_relighter_source(relighter, 0).name,
            { 0.25f, 0.25f, 0.25f } };
        const rsv_relight_desc desc = { .light = &scale, .light_count = 1 };
        status = rsv_relighter_prepare(relighter);
        cli_cost started = cli_cost_now();
        if (status == RSV_OK) status = rsv_relighter_change(relighter, &desc);
        if (status == RSV_OK) status = rsv_relighter_settle(relighter);
        m->relight[quality] = cli_cost_since(started);
    }
    rsv_relighter_destroy(relighter);
    return status;
}

static rsv_status measure_quality(measurement *m, int quality)
{
    rsv_solve_desc desc = rsv_default_solve_desc((rsv_quality)quality);
    rsv_light *light = NULL;
    desc.direct_level = false;
    cli_cost started = cli_cost_now();
    rsv_status status = rsv_light_create(m->scene, &desc, &light);
    m->solve[quality] = cli_cost_since(started);
    if (status == RSV_OK) status = climb(m, light, quality, FIRST);
    if (status == RSV_OK) status = climb(m, light, quality, SECOND);
    if (status == RSV_OK) status = relight(m, light, quality);
    rsv_light_destroy(light);
    return status;
}

// ---- what follows -------------------------------------------------------------------------------

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

/// All that a picture takes whose error is known.
static cli_cost cost_of(const measurement *m, int quality, view_kind view, double error)
{
    const curve *c = &m->curve[quality][view == SECOND ? SECOND : FIRST];
    cli_cost picture = cost_of_error(c, error);
    if (view == FIRST) picture = add(picture, add(m->load, m->solve[quality]));
    return view == RELIT ? add(picture, m->relight[quality]) : picture;
}

/// The quality by which an error is reached soonest. An error that none reaches has no numbers.
static cJSON *describe_time(const measurement *m, view_kind view, double error)
{
    int best = 0;
    cJSON *time = cJSON_CreateObject();
    for (int q = 1; q <= m->bench->quality; q++)
        if (cost_of(m, q, view, error).cpu_seconds < cost_of(m, best, view, error).cpu_seconds)
            best = q;
    cli_cost ours = cost_of(m, best, view, error);
    double reference = cli_reference_seconds(&m->view[view == SECOND ? SECOND : FIRST], error);
    if (view == FIRST) reference += m->load.cpu_seconds;
    bool reached = isfinite(ours.cpu_seconds);
    cJSON_AddStringToObject(time, "view", view_names[view]);
    cJSON_AddNumberToObject(time, "relative_mse", error);
    if (reached) cJSON_AddStringToObject(time, "quality", cli_quality_names[best]);
    cJSON_AddNumberToObject(time, "seconds", reached ? ours.seconds : NAN);
    cJSON_AddNumberToObject(time, "cpu_seconds", reached ? ours.cpu_seconds : NAN);
    cJSON_AddNumberToObject(time, "reference_cpu_seconds", reference);
    cJSON_AddNumberToObject(time, "factor", reached ? reference / ours.cpu_seconds : NAN);
    return time;
}

static rsv_status measure(measurement *m, const char *name, cJSON *result)
{
    cli_size size = m->bench->frame_size;
    rsv_status status = cli_judged_views_create(m->bench, m->scene, name, size, m->view);
    m->points = cJSON_AddArrayToObject(result, "points");
    for (int q = 0; q <= m->bench->quality && status == RSV_OK; q++)
        status = measure_quality(m, q);
    if (status != RSV_OK) return status;
    cJSON *times = cJSON_AddArrayToObject(result, "times");
    for (int view = FIRST; view < VIEWS; view++)
        for (size_t k = 0; k < wanted_count; k++)
            cJSON_AddItemToArray(times, describe_time(m, (view_kind)view, wanted[k]));
    return RSV_OK;
}

bool cli_bench_pictures(const cli_bench_task *bench, cJSON *result)
{
    cli_room_files room;
    measurement m = { .bench = bench };
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

// ---- what is said -------------------------------------------------------------------------------

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
    puts("\n| scene | view | relative MSE | best fixed quality | clock, s | processors, s | mode "
         "reference, s | times as fast |\n|---|---|---|---|---|---|---|---|");
    cJSON_ArrayForEach(s, scenes)
    {
        cJSON_ArrayForEach(time, cJSON_GetObjectItem(s, "times"))
        {
            const char *quality = cJSON_GetStringValue(cJSON_GetObjectItem(time, "quality"));
            printf("| %s | %s | %g | %s |", cJSON_GetStringValue(cJSON_GetObjectItem(s, "scene")),
                cJSON_GetStringValue(cJSON_GetObjectItem(time, "view")),
                cli_json_number(time, "relative_mse"), quality ? quality : "-");
            print_number(" %.2f |", cli_json_number(time, "seconds"));
            print_number(" %.2f |", cli_json_number(time, "cpu_seconds"));
            print_number(" %.1f |", cli_json_number(time, "reference_cpu_seconds"));
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
