/// Plans by time. The clock decides how fine the solution is and when the last pass begins.
#include "../core/team.h"
#include "planner.h"

#include <math.h>
#include <stdio.h>

#define COARSEST_ELEMENTS 500
#define COARSEST_RAYS 64
#define COARSEST_PHOTONS 40000
#define FINE_PHOTONS 250000
#define FINE_RAYS 256
/// Parts of the time that is left: a solution may take the first before it is given up; a second, finer one aims at the
/// other.
#define SOLUTION_SHARE 0.6
#define FINER_SHARE 0.3
/// A finer solution is worthwhile from this many times the elements on. Costs of solutions besides rows do not grow
/// with them.
#define WORTH_IT 4.0
#define MOST_FINER 60.0
#define MOST_PASS 64.0
/// Passes may take this many times as long as the previous one predicts.
#define DOUBT 1.1
/// Part of the time left that a pass may take, and camera rays per pixel of the shortest.
#define PASS_SHARE 0.5
#define LAST_PASS 0.1
/// Cost of a camera ray where pictures are noisy, relative to the mean: until it is known.
#define UNEVEN_COST 1.3

/// Seconds per triangle that even the coarsest solution takes: a mesh of 4 million triangles takes 4 s.
#define LEAST_PER_TRIANGLE 1e-6

static double now_of(const rsv_planner *p)
{
    return rsv_team_largest(p->context, rsv_seconds() - p->started);
}

static rsv_status stopped_by_deadline(const rsv_planner *p, rsv_status status)
{
    bool only_late = status == RSV_ERROR_CANCELLED && !rsv_was_asked_to_stop(p->context);
    return only_late ? RSV_OK : status;
}

/// Solves until a time, or leaves things as they were. Processes of a team do not part: they take their time.
static rsv_status solve_until(rsv_planner *p, double seconds)
{
    bool alone = rsv_team_of(p->context) == NULL;
    if (alone) rsv_set_deadline(p->context, p->started + seconds);
    rsv_status status = rsv_planner_solve(p);
    rsv_set_deadline(p->context, INFINITY);
    rsv_progress_part(p->context, NULL, 0);
    return stopped_by_deadline(p, status);
}

/// The coarsest solution, and one as fine as there is time for.
static rsv_status find_solution(rsv_planner *p, double seconds)
{
    double begun = now_of(p);
    p->solve.element_target = COARSEST_ELEMENTS;
    p->solve.rays_per_element = COARSEST_RAYS;
    p->solve.photon_count = COARSEST_PHOTONS;
    p->solve.refinements = 0;
    p->solve.goal_camera = RSV_NONE;
    rsv_status status = solve_until(p, begun + SOLUTION_SHARE * (seconds - begun));
    double now = now_of(p);
    double finer = fmin(FINER_SHARE * (seconds - now) / (now - begun), MOST_FINER);
    if (status != RSV_OK || !p->light || finer < WORTH_IT) return status;
    p->solve.element_target = (uint32_t)(COARSEST_ELEMENTS * finer / 2);
    p->solve.photon_count = FINE_PHOTONS;
    if (finer > 2 * WORTH_IT) p->solve.rays_per_element = FINE_RAYS;
    return solve_until(p, now + SOLUTION_SHARE * (seconds - now));
}

static bool is_path_traced(const rsv_planner *p) { return p->picture.mode == RSV_RENDER_REFERENCE; }

/// Two passes of one sample each, which show the noise, if there is time. @param of_one out: seconds per pass
static rsv_status take_first(rsv_planner *p, double seconds, double *of_one)
{
    rsv_status status = RSV_OK;
    double before = now_of(p);
    *of_one = 0;
    for (uint32_t pass = 0; pass < 2 && status == RSV_OK; pass++) {
        if (pass > 0 && DOUBT * *of_one > seconds - before) break;
        status = rsv_planner_take(p, 1);
        *of_one = now_of(p) - before;
        before += *of_one;
    }
    if (status == RSV_OK && p->sum.samples > 1 && !is_path_traced(p))
        status = rsv_sample_sum_filter(p->context, &p->sum, RSV_STRATIFIED_FALL);
    if (status == RSV_OK && p->sum.samples > 1)
        p->plan.noise = rsv_sample_sum_noise(&p->sum, is_path_traced(p) ? 1 : RSV_STRATIFIED_FALL);
    return status;
}

/// Camera rays per pixel of the next pass. Each pass uses a part of the time left, so that the next one can make up for
/// a pass that takes longer than expected. No last pass is taken that would be too short. Path-traced passes have whole
/// numbers.
static double next_pass(const rsv_planner *p, double left, double of_one)
{
    double fits = left / fmax(of_one, 1e-6), part = PASS_SHARE * fits;
    double most = fmin(p->sum.samples, MOST_PASS);
    if (is_path_traced(p)) return fmin(floor(fits / DOUBT), most);
    return fits < LAST_PASS ? 0 : fmin(fmax(part, LAST_PASS / DOUBT), most);
}

static rsv_status take_evenly(rsv_planner *p, double samples, double *taken)
{
    *taken = samples;
    rsv_status status = rsv_planner_take(p, (uint32_t)samples);
    if (status == RSV_OK) p->plan.noise = rsv_sample_sum_noise(&p->sum, 1);
    return status;
}

/// @param taken out: camera rays per pixel; 0 = none is of use
static rsv_status take_where_noisy(rsv_planner *p, double samples, double *taken)
{
    rsv_allocation allocation = { 0 };
    rsv_status status = rsv_allocate_samples(
        p->context, &p->sum, RSV_STRATIFIED_FALL, p->wanted, samples, &allocation);
    *taken = allocation.mean;
    if (status == RSV_OK && allocation.mean > 0)
        status = rsv_planner_take_allocated(p, &allocation);
    rsv_allocation_clear(p->context, &allocation);
    return status;
}

/// Passes as long as there is time for them, of more and more samples, where the picture is noisy.
static rsv_status take_passes(rsv_planner *p, double seconds)
{
    double of_one;
    rsv_status status = take_first(p, seconds, &of_one);
    if (!is_path_traced(p)) {
        of_one *= UNEVEN_COST;
        if (status == RSV_OK) status = rsv_planner_find_outlines(p);
    }
    while (status == RSV_OK && p->sum.samples > 1 && !(p->plan.noise <= p->wanted)) {
        double before = now_of(p), samples = next_pass(p, seconds - before, of_one), taken;
        if (samples <= 0) break;
        status = is_path_traced(p) ? take_evenly(p, samples, &taken)
                                   : take_where_noisy(p, samples, &taken);
        if (status != RSV_OK || taken <= 0) break;
        of_one = (now_of(p) - before) / taken;
    }
    return status;
}

static void say_plan(const rsv_planner *p, double seconds)
{
    const rsv_picture_plan *plan = &p->plan;
    char light[64] = "path tracing (no time for a solution)", noise[48] = "";
    if (p->light)
        snprintf(light, sizeof light, "%zu rows of %u rays", rsv_light_report(p->light)->rows,
            plan->rays_per_element);
    if (!isnan(plan->noise))
        snprintf(noise, sizeof noise, ", noise %.2g %%", 100 * sqrt(plan->noise));
    rsv_log(p->context, RSV_LOG_INFO, "plan: %s and %u camera rays per pixel in %.3g s%s", light,
        p->sum.samples, seconds, noise);
}

rsv_status rsv_planner_run_until(rsv_planner *p, double seconds)
{
    rsv_status status;
    double least = LEAST_PER_TRIANGLE * (double)rsv_scene_get_view(p->scene)->triangle_count;
    if (!p->light && seconds - now_of(p) > least) RSV_TRY(find_solution(p, seconds));
    if (!p->light) p->plan.mode = p->picture.mode = RSV_RENDER_REFERENCE;
    RSV_TRY(take_passes(p, seconds));
    p->plan.is_reached = p->plan.noise <= p->wanted;
    say_plan(p, now_of(p));
cleanup:
    return status;
}
