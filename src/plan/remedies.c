#include "remedies.h"

#include "elements_error.h"
#include "plan_constants.h"

#include <math.h>

rsv_refinement rsv_next_refinement(const rsv_planner *p)
{
    double excess = p->plan.elements_error / (ELEMENTS_SHARE * p->wanted);
    if (p->is_stuck)
        return (rsv_refinement){ 1, p->solve.rays_per_element < MOST_RAYS ? STUCK_RAYS : 1 };
    bool needs_rays = excess > RAYS_EXCESS && p->solve.rays_per_element < MOST_RAYS;
    return (rsv_refinement){ fmin(fmax(REFINED_BY * excess, LEAST_REFINEMENT), MOST_REFINEMENT),
        needs_rays ? 2 : 1 };
}

/// Cost, in rays of rows, of the camera rays that bring noise down so far. INFINITY = it takes too many.
static double cost_of_samples(const rsv_planner *p, double noise, double allowed, bool gathered)
{
    double pixels = (double)p->picture.width * p->picture.height;
    double fall = gathered ? RSV_GATHERED_FALL : RSV_STRATIFIED_FALL;
    uint32_t samples = rsv_samples_for(noise / allowed, p->sum.samples, fall, MOST_SAMPLES);
    if (samples == MOST_SAMPLES) return INFINITY;
    return samples * (gathered ? GATHERED_COST : SAMPLE_COST) * pixels;
}

/// The same where elements leave little of the target to noise. INFINITY = the error would be too large.
static double cost_of_accepting(const rsv_planner *p, double elements)
{
    double allowed = rsv_noise_beside(p, elements);
    double excess = fmax((elements + allowed) / p->wanted, 1);
    if (excess > TOLERANCE * TOLERANCE) return INFINITY;
    return pow(excess, EXCESS_POWER) * cost_of_samples(p, p->plan.noise, allowed, false);
}

/// Cost of a finer solution in rays of rows.
static double cost_of_rows(const rsv_planner *p)
{
    const rsv_solve_report *report = rsv_light_report(p->light);
    rsv_refinement next = rsv_next_refinement(p);
    return next.elements * next.rays * (double)report->row_rays + (double)report->rows * ROW_COST;
}

/// Relative MSE by noise if all pixels gather, with a gather ray for each of the camera rays there are.
static double noise_of_gathering(const rsv_planner *p)
{
    double more = fmax(p->gathered_noise - p->looked_up_noise, 0);
    return p->picture.denoise ? p->plan.noise + FILTERED_GATHERING * more : p->gathered_noise;
}

/// Cost of a picture with gather rays. INFINITY = the error would be too large, and a finer solution may follow.
static double cost_of_gathering(const rsv_planner *p, bool is_last)
{
    double left = p->gathered_left;
    if (left > ELEMENTS_SHARE * p->wanted && !is_last) return INFINITY;
    double allowed = rsv_noise_beside(p, left);
    return cost_of_samples(p, noise_of_gathering(p), allowed, true);
}

rsv_remedy rsv_choose_remedy(const rsv_planner *p, bool is_last)
{
    double accepted = cost_of_accepting(p, rsv_likely_elements_error(p));
    double gathered = cost_of_gathering(p, is_last);
    double refined = cost_of_rows(p) + cost_of_samples(p, p->plan.noise, p->wanted, false);
    if (is_last) refined = INFINITY;
    if (gathered < fmin(accepted, refined)) return RSV_GATHER;
    return is_last || accepted <= refined ? RSV_ACCEPT : RSV_REFINE;
}
