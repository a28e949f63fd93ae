#include "solution.h"

#include "../core/team.h"
#include "../elements/elements_internal.h"
#include "budget.h"
#include "coarse_elements.h"
#include "goal.h"
#include "pilot.h"
#include "remember.h"
#include "source.h"
#include "system.h"

#include <string.h>

/// Where budgets are exceeded, elements grow by this factor at most at a time; always by it, and no pilot splits them, as
/// soon as a step leaves more than this part of them.
#define LARGEST_STEP 4.0f
#define LEAST_PROGRESS 0.95
/// Elements that are larger than wanted by this factor are as few as the surfaces can have.
#define COARSEST 1e3f

rsv_solve_desc rsv_default_solve_desc(rsv_quality quality)
{
    static const rsv_solve_desc presets[] = {
        [RSV_QUALITY_DRAFT] = { .element_target = 3000,
            .rays_per_element = 256,
            .refinements = 0,
            .light_samples = 16,
            .photon_count = 300000,
            .direct_levels = 2 },
        [RSV_QUALITY_MEDIUM] = { .element_target = 7000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 16,
            .photon_count = 1500000,
            .direct_levels = 3 },
        [RSV_QUALITY_HIGH] = { .element_target = 24000,
            .rays_per_element = 1024,
            .refinements = 3,
            .light_samples = 32,
            .photon_count = 6000000,
            .direct_levels = 4 },
    };
    rsv_solve_desc desc = presets[quality];
    desc.direct_level = true;
    desc.max_orders = 4096;
    desc.tolerance = 1e-4f;
    desc.goal_camera = RSV_NONE;
    desc.goal_points = NULL;
    desc.goal_point_count = 0;
    desc.seed = 1;
    return desc;
}

static bool is_power_of_two(uint32_t value) { return value && (value & (value - 1)) == 0; }

static rsv_status check_desc(const rsv_solve_desc *desc)
{
    if (desc->element_target == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: element_target must be positive");
    if (!is_power_of_two(desc->rays_per_element) || desc->rays_per_element < RSV_FEWEST_RAYS ||
        desc->rays_per_element > 4096)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: rays_per_element is %u; it must be a power of two from 64 to 4096",
            desc->rays_per_element);
    if (!is_power_of_two(desc->light_samples) || desc->light_samples < 16 ||
        desc->light_samples > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: light_samples is %u; it must be a power of two from 16 to 65536",
            desc->light_samples);
    if (desc->max_orders == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: max_orders must be positive");
    if (!(desc->tolerance > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: tolerance must be positive");
    return RSV_OK;
}

void rsv_solution_find_bsdfs(rsv_solution *s)
{
    for (uint32_t m = 0; m < s->scene.view->material_count; m++)
        s->bsdf[m] = rsv_surface_common_bsdf(s->scene.view, m);
}

static rsv_status create_bsdfs(rsv_solution *s)
{
    s->bsdf = rsv_alloc(s->context, s->scene.view->material_count, sizeof *s->bsdf);
    if (!s->bsdf) return RSV_ERROR_MEMORY;
    rsv_solution_find_bsdfs(s);
    s->scene.bsdf = s->bsdf;
    return RSV_OK;
}

/// Creates elements, larger ones as long as there are more than budgets allow.
static rsv_status create_elements(rsv_solution *s)
{
    rsv_status status;
    s->spacing = rsv_spacing_for(&s->scene, s->desc.element_target);
    if (s->scene.past) s->spacing = rsv_past_spacing(s->scene.past, s->spacing);
    float wanted = s->wanted_metres = s->spacing.metres;
    size_t before = SIZE_MAX;
    bool stalled = false;
    RSV_TRY(rsv_budget_open(s));
    for (;;) {
        RSV_TRY(rsv_coarse_elements_create(s, rsv_pilot_has_goal(s) ? RSV_GOAL_LEARNED : 1));
        if (!stalled) RSV_TRY(rsv_pilot_refine(s));
        while (rsv_solution_rows(s) > rsv_budget_rows(s) && rsv_budget_halve_rays(s)) {}
        size_t rows = rsv_solution_rows(s), most = rsv_budget_rows(s);
        if (rows <= most) break;
        s->scene.past = NULL; // its grids and splits would stay as they were
        if (s->spacing.metres > COARSEST * wanted) RSV_TRY(rsv_budget_refuse(s, rows));
        stalled = stalled || (double)rows > LEAST_PROGRESS * (double)before;
        before = rows;
        float step = sqrtf(1.2f * (float)rows / ((float)most + 1));
        s->spacing.metres *= stalled ? LARGEST_STEP : f_min(step, LARGEST_STEP);
        rsv_elements_destroy(s->elements);
        s->elements = NULL;
    }
    rsv_budget_report(s, wanted);
cleanup:
    return status;
}

/// Errors of the operator are amplified by about 1 / (1 - spectral radius): beyond this the reader must know.
#define WORRYING_RADIUS 0.98

static void warn_if_unbounded(const rsv_solution *s)
{
    const rsv_solve_report *report = &s->report;
    if (s->pocket_area > 0)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: %.3g m2 of surfaces that absorb nothing enclose pockets which hardly any light "
            "enters, and are left dark there; lower their albedo below 1",
            s->pocket_area);
    if (report->stop_reason == RSV_STOP_MAX_ORDERS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: stopped after %u orders of light with a residual of %.3g W/m2",
            report->iterations, report->residual_inf);
    else if (report->stop_reason > RSV_STOP_NO_LIGHT)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: solver %s gave up after %u applications with a residual of %.3g W/m2; leave "
            "the choice to 'auto'",
            rsv_solver_name(report->solver), report->iterations, report->residual_inf);
    else if (report->stop_reason == RSV_STOP_CONVERGED && report->norm_inf > WORRYING_RADIUS &&
             report->spectral_radius > WORRYING_RADIUS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: the scene absorbs almost nothing (spectral radius %.4f): small errors of the "
            "operator weigh heavily; use a higher quality or lower the albedos",
            report->spectral_radius);
}

static size_t count_nodes(const rsv_elements *elements)
{
    return elements ? elements->node_count : 0;
}

static rsv_status prepare(rsv_solution *s)
{
    rsv_status status;
    double start = rsv_seconds();
    RSV_TRY(create_bsdfs(s));
    RSV_TRY(rsv_tracer_create(s->scene.scene, &s->tracer));
    s->scene.tracer = s->tracer;
    s->scene.media = rsv_media_of(s->scene.view, s->tracer, s->bsdf);
    s->report.time_bvh = rsv_seconds() - start;
    RSV_TRY(rsv_lights_create(s->scene.scene, s->bsdf, &s->lights));
    RSV_TRY(rsv_source_divide_environment(s));
cleanup:
    return status;
}

static rsv_status keep_goal_points(rsv_solution *s)
{
    size_t count = s->desc.goal_point_count;
    const rsv_probe *points = s->desc.goal_points;
    s->desc.goal_points = NULL;
    if (count == 0) return RSV_OK;
    s->goal_points = rsv_alloc(s->context, count, sizeof *points);
    if (!s->goal_points) return RSV_ERROR_MEMORY;
    memcpy(s->goal_points, points, count * sizeof *points);
    s->desc.goal_points = s->goal_points;
    return RSV_OK;
}

rsv_status rsv_solution_prepare(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_solution **solution)
{
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_status status = check_desc(desc);
    if (status != RSV_OK) return status;
    rsv_solution *s = rsv_alloc(context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->context = context;
    s->desc = *desc;
    s->wanted_rays = desc->rays_per_element;
    s->scene = (rsv_transport_scene){ .scene = scene,
        .view = rsv_scene_get_view(scene),
        .checkpoint = desc->checkpoint,
        .earlier = desc->earlier };
    status = keep_goal_points(s);
    if (status == RSV_OK) status = prepare(s);
    if (status == RSV_OK)
        *solution = s;
    else
        rsv_solution_destroy(s);
    return status;
}

rsv_status rsv_solution_follow_strengths(rsv_solution *s, bool *followed)
{
    rsv_solution_find_bsdfs(s);
    return rsv_lights_follow_strengths(s->lights, s->bsdf, followed);
}

rsv_status rsv_solution_refresh(rsv_solution *s, const rsv_lights *like)
{
    rsv_status status;
    rsv_lights_destroy(s->lights);
    s->lights = NULL;
    rsv_solution_find_bsdfs(s);
    RSV_TRY(rsv_lights_create(s->scene.scene, s->bsdf, &s->lights));
    RSV_TRY(rsv_lights_gather_like(s->lights, like));
    rsv_free(s->context, s->bin_radiance);
    RSV_TRY(rsv_source_divide_environment(s));
cleanup:
    return status;
}

rsv_status rsv_solution_solve_again(rsv_solution *s)
{
    rsv_status status;
    double start = rsv_seconds();
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        rsv_free(s->context, s->order[k]);
        s->order[k] = NULL;
    }
    rsv_free(s->context, s->irradiance);
    rsv_free(s->context, s->indirect);
    s->irradiance = s->indirect = NULL;
    RSV_TRY(rsv_solve_and_measure(s));
    rsv_diffused_level_destroy(s->context, &s->diffused);
    RSV_TRY(rsv_diffused_level_create(s));
    s->report.time_solve = rsv_seconds() - start;
    warn_if_unbounded(s);
cleanup:
    return status;
}

static void report_kept_rays(const rsv_solution *s)
{
    const rsv_solve_report *r = &s->report;
    if (r->kept_row_rays > 0)
        rsv_log(s->context, RSV_LOG_INFO,
            "checkpoint: %.1f %% of the rays of rows kept from before the edit, %.1f %% traced "
            "again: %.1f s saved",
            100 * (double)r->kept_row_rays / (double)r->row_rays,
            100 * (1 - (double)r->kept_row_rays / (double)r->row_rays), fmax(r->spared_seconds, 0));
}

static rsv_status build(rsv_solution *s)
{
    rsv_status status;
    rsv_past *past = NULL;
    double start = rsv_seconds(), path = rsv_team_path(s->context);
    RSV_TRY(rsv_solution_recall(s, &past));
    RSV_TRY(create_elements(s));
    RSV_TRY(rsv_system_create_fields(s));
    RSV_TRY(rsv_system_assemble(
        s, rsv_reflects_diffusely(s) ? s->desc.rays_per_element : RSV_FEWEST_RAYS));
    RSV_TRY(rsv_subsurface_create(s->elements, &s->subsurface));
    RSV_TRY(rsv_source_create_levels(s));
    RSV_TRY(rsv_source_create(s));
    double assembled = rsv_seconds(), path_assembled = rsv_team_path(s->context);
    s->report.time_assemble = assembled - start;
    s->report.critical_assemble = path_assembled - path;

    s->report.elements = s->elements->node_count;
    s->report.rows = rsv_solution_rows(s);
    s->report.direct_elements = count_nodes(s->fine.elements) + count_nodes(s->caustics.elements);
    s->report.entries = rsv_team_total(s->context, rsv_transport_entries(s->transport)) +
                        rsv_subsurface_entries(s->subsurface);
    RSV_TRY(rsv_solve_and_measure(s));
    RSV_TRY(rsv_diffused_level_create(s));
    s->report.time_solve = rsv_seconds() - assembled;
    s->report.critical_solve = rsv_team_path(s->context) - path_assembled;
    s->report.bytes = rsv_solution_bytes(s);
    report_kept_rays(s);
    warn_if_unbounded(s);
    rsv_solution_remember(s);
cleanup:
    s->scene.past = NULL;
    rsv_past_close(past);
    return status;
}

static rsv_status check_goal(const rsv_solve_desc *desc, size_t cameras)
{
    if (desc->goal_camera == RSV_NONE)
        return rsv_check_probes(desc->goal_points, desc->goal_point_count);
    if (desc->goal_point_count > 0)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "solve: goal_camera and goal_points are both given; one goal is all there can be");
    if (desc->goal_camera >= cameras)
        return rsv_fail(RSV_ERROR_ARGUMENT, "solve: goal_camera is %u; the scene has %zu cameras",
            desc->goal_camera, cameras);
    return RSV_OK;
}

rsv_status rsv_solution_create(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_solution **solution)
{
    rsv_solve_desc settings = desc ? *desc : rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    rsv_solution *s = NULL;
    rsv_status status = check_goal(&settings, rsv_scene_get_view(scene)->camera_count);
    if (status == RSV_OK) status = rsv_solution_prepare(scene, &settings, &s);
    if (status != RSV_OK) return status;
    status = build(s);
    if (status != RSV_OK) {
        rsv_solution_destroy(s);
        return status;
    }
    *solution = s;
    return RSV_OK;
}

void rsv_solution_destroy(rsv_solution *s)
{
    if (!s) return;
    rsv_context *context = s->context;
    rsv_light_basis_destroy(s->basis);
    rsv_diffused_level_destroy(context, &s->diffused);
    rsv_source_level_destroy(context, &s->fine);
    rsv_source_level_destroy(context, &s->caustics);
    rsv_subsurface_destroy(s->subsurface);
    rsv_system_destroy(s);
    rsv_free(context, s->goal_points);
    rsv_free(context, s->valid_points);
    rsv_free(context, s->bin_radiance);
    rsv_elements_destroy(s->elements);
    rsv_lights_destroy(s->lights);
    rsv_tracer_destroy(s->tracer);
    rsv_free(context, s->bsdf);
    rsv_free(context, s);
}

const rsv_solve_report *rsv_solution_report(const rsv_solution *solution)
{
    return &solution->report;
}

const rsv_scene *rsv_solution_scene(const rsv_solution *solution) { return solution->scene.scene; }

uint32_t rsv_solution_order_count(const rsv_solution *solution) { return solution->order_count; }

rsv_rgb rsv_solution_direct(
    const rsv_solution *s, uint32_t face, float u, float v, bool skip_sampled)
{
    rsv_rgb sum = rsv_elements_interpolate(s->elements, s->gathered, face, u, v);
    if (s->caustics.caustic)
        sum = rgb_add(
            sum, rsv_elements_interpolate(s->caustics.elements, s->caustics.caustic, face, u, v));
    if (skip_sampled) return sum;
    if (s->fine.direct)
        return rgb_add(sum, rsv_elements_interpolate(s->fine.elements, s->fine.direct, face, u, v));
    return rsv_elements_interpolate(s->elements, s->source, face, u, v);
}

rsv_rgb rsv_solution_irradiance(
    const rsv_solution *s, uint32_t triangle, float u, float v, bool back_side, uint32_t order)
{
    uint32_t face = s->elements->face_of[back_side][triangle];
    if (face == RSV_NONE) return rgb_gray(0);
    if (order == 0) return rsv_solution_direct(s, face, u, v, false);
    if (order != RSV_NONE)
        return order < s->order_count
                   ? rsv_elements_interpolate(s->elements, s->order[order], face, u, v)
                   : rgb_gray(0);
    return rgb_add(rsv_solution_direct(s, face, u, v, false),
        rsv_elements_interpolate(s->elements, s->indirect, face, u, v));
}

rsv_status rsv_measure_assembly(const rsv_solution *s, rsv_assembly_cost *cost)
{
    rsv_transport *again = NULL;
    uint32_t rays = s->desc.rays_per_element;
    double start = rsv_seconds();
    rsv_status status = rsv_transport_create(
        &s->scene, s->lights, s->elements, s->valid_points, rays, s->desc.seed, &again);
    if (status != RSV_OK) return status;
    cost->assembly_seconds = rsv_seconds() - start;
    rsv_transport_destroy(again);
    return rsv_transport_trace_only(&s->scene, s->elements, s->valid_points, rays, s->desc.seed,
        &cost->rays, &cost->tracing_seconds, &cost->single_seconds);
}
