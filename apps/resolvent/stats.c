#include "stats.h"

#include "crew.h"
#include "device.h"
#include "output_file.h"

#include <cJSON.h>
#include <math.h>
#include <sys/resource.h>

const char *const cli_quality_names[] = { [RSV_QUALITY_DRAFT] = "draft",
    [RSV_QUALITY_MEDIUM] = "medium",
    [RSV_QUALITY_HIGH] = "high",
    NULL };

static const char *stop_reason_name(rsv_stop_reason reason)
{
    switch (reason) {
    case RSV_STOP_CONVERGED:
        return "converged";
    case RSV_STOP_MAX_ORDERS:
        return "max_orders";
    case RSV_STOP_NO_LIGHT:
        return "no_light";
    case RSV_STOP_STAGNATED:
        return "stagnated";
    case RSV_STOP_DIVERGED:
        return "diverged";
    case RSV_STOP_BREAKDOWN:
        return "breakdown";
    }
    return "unknown";
}

static double peak_rss_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * (double)usage.ru_maxrss;
}

/// A number of a picture, null for probes.
static void add_if_positive(cJSON *object, const char *name, uint32_t value)
{
    cJSON_AddNumberToObject(object, name, value ? (double)value : NAN);
}

static void add_text(cJSON *object, const char *name, const char *text)
{
    cJSON_AddItemToObject(object, name, text ? cJSON_CreateString(text) : cJSON_CreateNull());
}

static void add_settings(cJSON *root, const cli_stats *stats)
{
    cJSON_AddStringToObject(root, "version", rsv_version());
    cJSON_AddStringToObject(root, "command", stats->command);
    cJSON_AddStringToObject(root, "scene", stats->scene);
    cJSON_AddStringToObject(root, "mode", stats->mode);
    add_text(root, "quality", stats->is_planned ? NULL : cli_quality_names[stats->quality]);
    add_if_positive(root, "width", stats->width);
    add_if_positive(root, "height", stats->height);
    cJSON_AddNumberToObject(root, "spp", stats->samples);
    cJSON_AddNumberToObject(root, "threads", stats->threads);
    cJSON_AddStringToObject(
        root, "device", cli_device() ? rsv_device_get_info(cli_device())->name : "cpu");
    cJSON_AddNumberToObject(root, "seed", stats->seed);
    // without the digits that floats make up
    double stops = stats->exposure ? round((double)*stats->exposure * 1e6) / 1e6 : NAN;
    cJSON_AddNumberToObject(root, "exposure", stops);
}

/// cJSON writes NAN as null, for a norm or residual that does not exist.
static void add_solution(cJSON *root, const cli_stats *stats)
{
    static const rsv_solve_report nothing = { .norm_inf = NAN,
        .spectral_radius = NAN,
        .residual_inf = NAN,
        .truncation_bound = NAN,
        .mean_irradiance = NAN };
    const rsv_solve_report *report = stats->report ? stats->report : &nothing;
    double rays = (double)report->rays;
    cJSON_AddNumberToObject(root, "elements", (double)report->elements);
    cJSON_AddNumberToObject(root, "direct_elements", (double)report->direct_elements);
    cJSON_AddNumberToObject(root, "rows", (double)report->rows);
    cJSON_AddNumberToObject(root, "entries", (double)report->entries);
    cJSON_AddNumberToObject(root, "operator_bytes", (double)report->bytes);
    cJSON_AddNumberToObject(root, "rays", rays);
    cJSON_AddNumberToObject(root, "row_rays", (double)report->row_rays);
    cJSON_AddNumberToObject(root, "kept_row_rays", (double)report->kept_row_rays);
    cJSON_AddNumberToObject(root, "spared_seconds", report->spared_seconds);
    cJSON_AddNumberToObject(
        root, "rays_per_second", report->time_assemble > 0 ? rays / report->time_assemble : NAN);
    cJSON_AddNumberToObject(root, "iterations", report->iterations);
    cJSON_AddNumberToObject(root, "order_count", stats->order_count);
    add_text(root, "stop_reason", stats->report ? stop_reason_name(report->stop_reason) : NULL);
    add_text(root, "solver", stats->report ? rsv_solver_name(report->solver) : NULL);
    add_text(root, "solver_reason", stats->report ? report->solver_reason : NULL);
    cJSON_AddNumberToObject(root, "norm_inf", report->norm_inf);
    cJSON_AddNumberToObject(root, "spectral_radius", report->spectral_radius);
    cJSON_AddNumberToObject(
        root, "neumann_terms", report->neumann_terms ? (double)report->neumann_terms : NAN);
    cJSON_AddNumberToObject(root, "residual_inf", report->residual_inf);
    cJSON_AddNumberToObject(root, "truncation_bound", report->truncation_bound);
    cJSON_AddNumberToObject(root, "mean_irradiance", report->mean_irradiance);
    cJSON_AddNumberToObject(root, "standard_error", stats->standard_error);
}

static void add_interval(cJSON *object, const char *name, const double interval[2])
{
    cJSON_AddItemToObject(object, name, cJSON_CreateDoubleArray(interval, 2));
}

/// W/m2, luminance. cJSON writes an infinite bound as null.
static void add_certificate(cJSON *root, const rsv_certificate *c)
{
    if (!c) {
        cJSON_AddNullToObject(root, "certificate");
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(root, "certificate");
    cJSON_AddNumberToObject(object, "samples", c->samples);
    cJSON_AddNumberToObject(object, "residual_rms", c->residual_rms);
    add_interval(object, "residual_ci95", c->residual_ci95);
    cJSON_AddNumberToObject(object, "error_bound_rms", c->error_bound_rms);
    cJSON_AddNumberToObject(object, "error_estimate_rms", c->error_estimate_rms);
    add_interval(object, "error_estimate_ci95", c->error_estimate_ci95);
    cJSON_AddNumberToObject(object, "residual_direct_rms", c->residual_direct_rms);
    cJSON_AddNumberToObject(object, "residual_gathered_rms", c->residual_gathered_rms);
    cJSON_AddNumberToObject(object, "irradiance_rms", c->irradiance_rms);
    cJSON_AddNumberToObject(object, "max_albedo", c->max_albedo);
    cJSON_AddNumberToObject(object, "medium_factor", c->medium_factor);
    cJSON_AddNumberToObject(object, "amplification", c->amplification);
    cJSON_AddNumberToObject(object, "rays", (double)c->rays);
}

/// W/m2, luminance.
static void add_split(cJSON *root, const rsv_error_split *split)
{
    if (!split) return;
    cJSON *object = cJSON_AddObjectToObject(root, "error_split");
    cJSON_AddNumberToObject(object, "truncation", split->truncation);
    cJSON_AddNumberToObject(object, "sampling", split->sampling);
    cJSON_AddNumberToObject(object, "discretisation", split->discretisation);
}

/// Mean luminance of a camera's picture, W/(sr m2).
static void add_goal(cJSON *root, const rsv_goal_certificate *g)
{
    if (!g) return;
    cJSON *object = cJSON_AddObjectToObject(root, "goal_certificate");
    cJSON_AddNumberToObject(object, "reading", g->reading);
    cJSON_AddNumberToObject(object, "error", g->error);
    add_interval(object, "error_ci95", g->error_ci95);
}

/// How a planned picture was made.
static void add_plan(cJSON *root, const rsv_picture_plan *plan)
{
    cJSON *object = cJSON_AddObjectToObject(root, "plan");
    cJSON_AddBoolToObject(object, "path_traced", plan->mode == RSV_RENDER_REFERENCE);
    cJSON_AddNumberToObject(object, "element_target", plan->element_target);
    cJSON_AddNumberToObject(object, "rays_per_element", plan->rays_per_element);
    cJSON_AddNumberToObject(object, "refinements", plan->refinements);
    cJSON_AddBoolToObject(object, "goal", plan->goal);
    cJSON_AddBoolToObject(object, "gathers", plan->gathers);
    cJSON_AddNumberToObject(object, "gathered_share", plan->gathered_share);
    cJSON_AddNumberToObject(object, "rounds", plan->rounds);
    cJSON_AddNumberToObject(object, "noise_mse", plan->noise);
    cJSON_AddNumberToObject(object, "elements_mse", plan->elements_error);
    cJSON_AddBoolToObject(object, "reached", plan->is_reached);
}

/// Microseconds are digits enough.
static void add_seconds(cJSON *times, const char *phase, double seconds)
{
    cJSON_AddNumberToObject(times, phase, round(1e6 * seconds) / 1e6);
}

static void add_times(cJSON *root, const cli_session *session, const cli_stats *stats)
{
    static const rsv_solve_report nothing = { 0 };
    const rsv_solve_report *report = stats->report ? stats->report : &nothing;
    cJSON *times = cJSON_AddObjectToObject(root, "time_s");
    add_seconds(times, "load", session->time_load);
    add_seconds(times, "bvh", report->time_bvh);
    add_seconds(times, "assemble", report->time_assemble);
    add_seconds(times, "solve", stats->time_solve > 0 ? stats->time_solve : report->time_solve);
    add_seconds(times, "render", stats->time_render);
    add_seconds(times, "certify", stats->certificate ? stats->certificate->seconds : 0);
    add_seconds(times, "total", cli_seconds() - session->started);
}

static void add_warnings(cJSON *root, const cli_session *session)
{
    cJSON *warnings = cJSON_AddArrayToObject(root, "warnings");
    for (size_t i = 0; i < session->warnings.count; i++)
        cJSON_AddItemToArray(warnings, cJSON_CreateString(session->warnings.text[i]));
}

rsv_status cli_certify_briefly(
    const char *path, const rsv_light *solution, uint32_t seed, rsv_certificate *certificate)
{
    if (!path) return RSV_OK;
    rsv_certify_desc desc = rsv_brief_certify_desc();
    desc.seed = seed;
    return rsv_certify(solution, &desc, certificate);
}

static void add_more(cJSON *root, cJSON *more)
{
    while (more && more->child) {
        cJSON *item = cJSON_DetachItemViaPointer(more, more->child);
        cJSON_AddItemToObject(root, item->string, item);
    }
    cJSON_Delete(more);
}

bool cli_write_stats(const char *path, const cli_session *session, const cli_stats *stats)
{
    if (!cli_crew_speaks()) {
        cJSON_Delete(stats->more);
        return true;
    }
    cJSON *root = cJSON_CreateObject();
    add_settings(root, stats);
    add_more(root, stats->more);
    add_solution(root, stats);
    add_certificate(root, stats->certificate);
    add_split(root, stats->split);
    add_goal(root, stats->goal);
    if (stats->is_planned) add_plan(root, &stats->plan);
    add_times(root, session, stats);
    cJSON_AddNumberToObject(root, "peak_rss_bytes", peak_rss_bytes());
    add_warnings(root, session);
    bool written = cli_write_json(path, root);
    cJSON_Delete(root);
    return written;
}
