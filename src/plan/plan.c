/// Plans by error. Everything follows from the picture's size, the target error and the pilots. No clock is read, so a
/// plan is the same on every machine.
#include "../core/descriptor.h"
#include "../scene/scene.h"
#include "elements_error.h"
#include "plan_constants.h"
#include "planner.h"
#include "remedies.h"

#include <math.h>
#include <stdio.h>

void rsv_plan_desc_init(rsv_plan_desc *desc, size_t size)
{
    const rsv_plan_desc defaults = {
        .size = sizeof defaults, .relative_error = 0.07, .max_seconds = INFINITY
    };
    rsv_desc_fill(desc, size, &defaults);
}

// ---- solutions --------------------------------------------------------------------------------------

static uint32_t power_of_two(double value, uint32_t least, uint32_t most)
{
    uint32_t power = least;
    while (power < most && power * M_SQRT2 < value)
        power *= 2;
    return power;
}

static uint32_t photons_for(double accuracy)
{
    return (uint32_t)fmin(fmax(USUAL_PHOTONS * accuracy, LEAST_PHOTONS), MOST_PHOTONS);
}

static float contacts_for(double accuracy)
{
    return (float)fmin(USUAL_CONTACTS * sqrt(accuracy), 1);
}

/// Elements and rows for an error. Photons and the solver always go by the target.
static void choose_elements_for(rsv_planner *p, double error)
{
    double pixels = (double)p->picture.width * p->picture.height;
    double accuracy = USUAL_ERROR / error, detail = fmin(pixels / USUAL_PIXELS, 1);
    double elements = USUAL_ELEMENTS * sqrt(accuracy * detail);
    p->solve.element_target = (uint32_t)fmin(fmax(elements, LEAST_ELEMENTS), MOST_ELEMENTS);
    p->solve.rays_per_element = power_of_two(USUAL_RAYS * accuracy, LEAST_RAYS, MOST_RAYS);
    p->solve.row_rays = (uint64_t)(ROW_RAYS_PER_PIXEL * fmin(accuracy, 1) * pixels);
    p->solve.photon_count = photons_for(USUAL_ERROR / p->wanted);
    p->solve.contact_share = contacts_for(accuracy);
    p->solve.tolerance = (float)(SOLVER_SHARE * sqrt(p->wanted));
    p->solve.refinements = 0;
    p->solve.goal_camera = RSV_NONE;
}

static void choose_elements(rsv_planner *p)
{
    choose_elements_for(p, p->wanted);
    if (p->wanted >= DEMANDING) return;
    if (rsv_scene_get_view(p->scene)->triangle_count < p->solve.element_target) {
        choose_elements_for(p, fmin(DEMANDING, EASED * p->wanted));
        return;
    }
    p->solve.refinements = REFINEMENTS;
    if (!p->picture.viewpoint && p->picture.film.projection == RSV_PROJECTION_CAMERA)
        p->solve.goal_camera = p->picture.camera;
}

static void choose_finer(rsv_planner *p)
{
    rsv_refinement next = rsv_next_refinement(p);
    p->solve.element_target =
        (uint32_t)fmin((double)p->solve.element_target * next.elements, MOST_ELEMENTS);
    p->solve.rays_per_element = (uint32_t)fmin(p->solve.rays_per_element * next.rays, MOST_RAYS);
    p->solve.photon_count = (uint32_t)fmin(2.0 * p->solve.photon_count, MOST_PHOTONS);
    p->solve.contact_share = fminf(2 * p->solve.contact_share, 1);
    if (!p->picture.viewpoint && p->picture.film.projection == RSV_PROJECTION_CAMERA)
        p->solve.goal_camera = p->picture.camera;
}

/// The picture begins again, with gather rays.
static rsv_status begin_gathering(rsv_planner *p)
{
    rsv_planner_forget_selection(p);
    p->picture.gather_rays = 1;
    p->plan.gathers = true;
    p->uncertainty *= p->gathered_left / p->plan.elements_error;
    p->plan.elements_error = p->gathered_left;
    return rsv_planner_take_first(p);
}

/// Refines elements while they limit the picture, it helps, and nothing else takes less time.
static rsv_status find_solution(rsv_planner *p)
{
    rsv_status status = p->light ? RSV_OK : rsv_planner_solve(p);
    double before = INFINITY;
    while (status == RSV_OK) {
        p->plan.elements_error = NAN;
        status = rsv_planner_take_first(p);
        if (status == RSV_OK) status = rsv_judge_elements(p);
        if (status != RSV_OK || !rsv_elements_limit(p)) break;
        if (!p->picture.denoise) status = rsv_gather_where_needed(p);
        if (status != RSV_OK || !rsv_elements_limit(p)) break;
        bool was_stuck = p->is_stuck;
        p->is_stuck = p->plan.elements_error > LEAST_PROGRESS * before;
        bool is_last = p->is_given || p->plan.rounds >= MOST_ROUNDS || (was_stuck && p->is_stuck);
        rsv_remedy next = rsv_choose_remedy(p, is_last);
        if (next == RSV_GATHER) status = begin_gathering(p);
        if (next != RSV_REFINE) break;
        before = p->plan.elements_error;
        choose_finer(p);
        status = rsv_planner_solve(p);
    }
    return status;
}

static void say_plan(const rsv_planner *p, uint32_t samples)
{
    const rsv_solve_report *report = rsv_light_report(p->light);
    const rsv_picture_plan *plan = &p->plan;
    char elements[80] = "",
         rays[32] = ""; // given solutions do not have the number of rays of their rows
    if (plan->rays_per_element) snprintf(rays, sizeof rays, " of %u rays", plan->rays_per_element);
    double least = 2 * p->uncertainty; // smallest significant value
    if (!isnan(plan->elements_error))
        snprintf(elements, sizeof elements, ", of which %s%.2g %% is due to elements",
            plan->elements_error < least ? "less than " : "",
            100 * sqrt(fmax(plan->elements_error, least)));
    char gathered[48] = "";
    if (plan->gathers) snprintf(gathered, sizeof gathered, ", with a gather ray each,");
    if (plan->gathered_share > 0)
        snprintf(gathered, sizeof gathered, ", with gather rays at %.2g %% of the pixels,",
            100 * plan->gathered_share);
    const char *unknown = rsv_picture_series_keeps_caustics(p->series)
                              ? "; the error of stored caustics is not known"
                              : "";
    rsv_log(p->context, RSV_LOG_INFO,
        "plan: %zu rows%s%s and %u camera rays per pixel%s for a relative error of %.2g "
        "%%%s%s",
        report->rows, rays, plan->goal ? " for this camera" : "", samples, gathered,
        100 * sqrt(p->wanted), elements, unknown);
}

static void say_what_is_missing(const rsv_planner *p)
{
    double elements = rsv_known_elements_error(p);
    rsv_log(p->context, RSV_LOG_WARNING,
        "plan: a relative error of %.2g %% cannot be reached: about %.2g %% is likely, %.2g %% due to elements "
        "and %.2g %% due to samples; request a larger error, or use --quality high",
        100 * sqrt(p->wanted), 100 * sqrt(elements + p->plan.noise), 100 * sqrt(elements),
        100 * sqrt(p->plan.noise));
}

/// Samples where the picture is noisy, until the noise found, not just that predicted, is as low as allowed.
static rsv_status take_passes(rsv_planner *p)
{
    rsv_status status = rsv_planner_find_outlines(p);
    double left = MOST_SAMPLES;
    for (int pass = 0; pass < MOST_PASSES && status == RSV_OK && left > 0; pass++) {
        rsv_allocation allocation = { 0 };
        double allowed = rsv_noise_allowed(p) * (pass == 0 ? 1 : RETAKE);
        status = rsv_allocate_samples(
            p->context, &p->sum, rsv_planner_fall(p), allowed, left, &allocation);
        if (status == RSV_OK && pass == 0)
            say_plan(p, p->sum.samples + (uint32_t)(allocation.mean + 0.5));
        if (status == RSV_OK) p->plan.noise = rsv_uneven_noise(&p->sum);
        left = allocation.mean > 0 ? left - allocation.mean : 0;
        rsv_progress_part(p->context, "pass", (uint32_t)pass + 1);
        if (status == RSV_OK && allocation.mean > 0)
            status = rsv_planner_take_allocated(p, &allocation);
        rsv_progress_part(p->context, NULL, 0);
        rsv_allocation_clear(p->context, &allocation);
    }
    return status;
}

/// Whether a picture is black whatever is solved.
static bool is_dark(const rsv_scene_view *view)
{
    for (size_t m = 0; m < view->material_count; m++)
        if (view->material[m].unlit) return false;
    return !rsv_scene_shines(view);
}

/// Without light, one path per pixel finds all there is.
static rsv_status take_dark(rsv_planner *p)
{
    p->plan.mode = p->picture.mode = RSV_RENDER_REFERENCE;
    p->plan.noise = p->plan.elements_error = 0;
    p->plan.is_reached = true;
    return rsv_planner_take(p, 1);
}

static rsv_status run_to_error(rsv_planner *p)
{
    choose_elements(p);
    rsv_status status = find_solution(p);
    if (status == RSV_OK) status = take_passes(p);
    double error = rsv_known_elements_error(p) + p->plan.noise;
    p->plan.is_reached = error <= TOLERANCE * TOLERANCE * p->wanted;
    if (status == RSV_OK && !p->plan.is_reached) say_what_is_missing(p);
    return status;
}

// ---- all of it ------------------------------------------------------------------------------------

static rsv_status check(const rsv_scene *scene, const rsv_plan_desc *desc, const rsv_render_desc *r)
{
    bool is_open = desc->relative_error == 0 && isfinite(desc->max_seconds);
    if (!is_open && !((float)desc->relative_error >= 0.005f && desc->relative_error <= 1))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "plan: a relative error of %g is not in 0.005 .. 1; for less, choose quality and samples",
            desc->relative_error);
    if (!(desc->max_seconds > 0))
        return rsv_fail(RSV_ERROR_ARGUMENT, "plan: max_seconds must be positive");
    if (r->mode != RSV_RENDER_FINAL)
        return rsv_fail(RSV_ERROR_ARGUMENT, "plan: only pictures of mode final are planned");
    if (r->camera >= rsv_scene_get_view(scene)->camera_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "plan: camera %u does not exist, the scene has %zu",
            r->camera, rsv_scene_get_view(scene)->camera_count);
    return rsv_scene_refuse_endless_fog(scene, "a planned picture");
}

static rsv_status begin(const rsv_scene *scene, const rsv_plan_desc *desc,
    const rsv_render_desc *picture, rsv_light *light, rsv_planner *p)
{
    *p = (rsv_planner){ .scene = scene,
        .context = rsv_scene_get_context(scene),
        .picture = *picture,
        .solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT),
        .light = light,
        .is_given = light != NULL,
        .started = rsv_seconds(),
        .gathered = picture->denoise ? RSV_GATHERED_INDIRECT : RSV_GATHERED_ALL,
        .wanted = desc->relative_error * desc->relative_error };
    p->picture.noise = 0;
    p->plan.mode = RSV_RENDER_FINAL;
    p->plan.elements_error = p->plan.noise = NAN;
    rsv_status status = RSV_READ_DESC(rsv_solve_desc, &p->solve, desc->solve);
    p->solve.direct_level = false;
    return status;
}

rsv_status rsv_render_planned(const rsv_scene *scene, const rsv_plan_desc *desc,
    const rsv_render_desc *picture, rsv_light **light, rsv_image **image, rsv_picture_plan *plan)
{
    rsv_plan_desc settings = rsv_default_plan_desc();
    rsv_render_desc seen = rsv_default_render_desc();
    rsv_status status = RSV_READ_DESC(rsv_plan_desc, &settings, desc);
    if (status == RSV_OK) status = RSV_READ_DESC(rsv_render_desc, &seen, picture);
    if (status == RSV_OK) status = rsv_scene_require_committed(scene);
    if (status == RSV_OK) status = check(scene, &settings, &seen);
    if (status != RSV_OK) return status;
    rsv_planner p;
    status = begin(scene, &settings, &seen, *light, &p);
    if (status != RSV_OK) return status;
    if (!p.light && is_dark(rsv_scene_get_view(scene)))
        status = take_dark(&p);
    else
        status = isfinite(settings.max_seconds) ? rsv_planner_run_until(&p, settings.max_seconds)
                                                : run_to_error(&p);
    rsv_picture_series_destroy(p.series);
    if (status == RSV_OK) status = rsv_sample_sum_finish(p.context, &p.sum, image);
    if (status == RSV_OK) {
        p.plan.samples = p.sum.samples;
        if (plan) *plan = p.plan;
        *light = p.light;
    } else if (!p.is_given) {
        rsv_light_destroy(p.light);
    }
    rsv_free(p.context, p.selected);
    rsv_sample_sum_clear(p.context, &p.sum);
    return status;
}
