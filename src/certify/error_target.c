/// Refinement until the certificate is content.
#include "../core/team.h"
#include "resolvent/certify.h"

#include <math.h>

/// Rounds aim this far below the target, so that the interval fits below it too.
#define AIM 0.75
/// A round multiplies elements and samples by at most this.
#define LARGEST_STEP 4.0
#define MOST_RAYS 4096
#define MOST_LIGHT_SAMPLES 4096
#define MOST_DIRECT_LEVELS 8
#define MOST_PHOTONS 500000000u
#define REFINEMENTS 3
/// A certificate that cannot tell is given more points, from the first number up to the second.
#define FIRST_SAMPLES 512
#define MOST_SAMPLES 65536

typedef struct pursuit {
    const rsv_scene *scene;
    const rsv_error_target *target;
    rsv_context *context;
    double started, round_started, round_seconds;
    rsv_solve_desc desc; ///< of the present round
    rsv_certify_desc certify;
    rsv_solution *solution;
    rsv_certificate *certificate;
    uint32_t rounds;
    double cost; ///< of the next round over the present one
    double size; ///< likewise its elements
} pursuit;

rsv_error_target rsv_default_error_target(double relative_error)
{
    return (rsv_error_target){ .relative_error = relative_error,
        .max_elements = 5000000,
        .max_seconds = INFINITY,
        .max_rounds = 8 };
}

static rsv_status check_target(const rsv_error_target *target)
{
    if (!(target->relative_error >= 1e-4 && target->relative_error <= 1))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "error target: relative_error is %g; it must be 0.0001 to 1", target->relative_error);
    if (target->max_elements == 0 || !(target->max_seconds > 0) || target->max_rounds == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "error target: budgets must be positive");
    return RSV_OK;
}

static double relative(const pursuit *p, double value)
{
    return p->certificate->irradiance_rms > 0 ? value / p->certificate->irradiance_rms : 0;
}

/// Certifies anew with more points as long as those are what keeps the interval above the target.
static rsv_status certify_decisively(pursuit *p)
{
    const rsv_certificate *c = p->certificate;
    for (;;) {
        rsv_status status = rsv_certify(p->solution, &p->certify, p->certificate);
        if (status != RSV_OK) return status;
        double wanted = p->target->relative_error;
        bool undecided = relative(p, c->error_estimate_rms) < AIM * wanted &&
                         relative(p, c->error_estimate_ci95[1]) > wanted;
        if (!undecided || p->certify.samples >= MOST_SAMPLES) return RSV_OK;
        p->certify.samples *= 4;
    }
}

static rsv_status build_round(pursuit *p)
{
    p->round_started = rsv_seconds();
    rsv_solution_destroy(p->solution);
    p->solution = NULL;
    rsv_status status = rsv_solution_create(p->scene, &p->desc, &p->solution);
    if (status == RSV_OK) status = certify_decisively(p);
    if (status != RSV_OK) return status;
    p->rounds++;
    p->round_seconds = rsv_seconds() - p->round_started;
    const rsv_solve_report *report = rsv_solution_report(p->solution);
    rsv_log(p->context, RSV_LOG_INFO,
        "error target: %.3g %% (95 %%: up to %.3g %%) with %zu elements and %u rays each",
        100 * relative(p, p->certificate->error_estimate_rms),
        100 * relative(p, p->certificate->error_estimate_ci95[1]),
        report->elements + report->direct_elements, p->desc.rays_per_element);
    return RSV_OK;
}

static uint32_t grown(uint32_t value, double factor, uint32_t most)
{
    return (uint32_t)fmin(value * factor, most > value ? most : value);
}

/// Doubles a power of two until it has grown by `factor` at least.
static uint32_t doubled(uint32_t value, double factor, uint32_t most)
{
    for (double reached = 1; reached < factor && value < most; reached *= 2)
        value *= 2;
    return value;
}

/// Direct light errs in its shadows' edges: the error falls with the size of the elements there.
static void refine_direct(pursuit *p, double excess)
{
    double step = fmin(excess * excess, LARGEST_STEP);
    p->desc.direct_levels += p->desc.direct_levels < MOST_DIRECT_LEVELS;
    p->desc.light_samples = doubled(p->desc.light_samples, step, MOST_LIGHT_SAMPLES);
    p->cost *= 2;
    p->size *= 2;
}

/// Noise falls with the root of the rays, interpolation with the area of elements: both get the same share.
static void refine_operator(pursuit *p, double excess)
{
    double step = fmin(fmax(excess * excess, 1.5), LARGEST_STEP);
    uint32_t rays = p->desc.rays_per_element;
    p->desc.element_target = grown(p->desc.element_target, step, UINT32_MAX);
    p->desc.rays_per_element = doubled(rays, step, MOST_RAYS);
    p->desc.photon_count = grown(p->desc.photon_count, 2 * step, MOST_PHOTONS);
    if (p->desc.refinements < REFINEMENTS) p->desc.refinements++;
    p->cost *= step * p->desc.rays_per_element / rays;
    p->size *= step;
}

/// Refines the parts of the residual that alone would use up half of what is allowed; the larger one at least.
static void choose_refinement(pursuit *p)
{
    const rsv_certificate *c = p->certificate;
    double allowed = AIM * p->target->relative_error * c->irradiance_rms;
    // reflections make more of a residual than it was
    double gain = c->residual_rms > 0 ? fmax(c->error_estimate_rms / c->residual_rms, 0.5) : 1;
    double direct = gain * c->residual_direct_rms / (M_SQRT1_2 * allowed);
    double gathered = gain * c->residual_gathered_rms / (M_SQRT1_2 * allowed);
    p->cost = p->size = 1;
    if (direct > 1 || direct > gathered) refine_direct(p, direct);
    if (gathered > 1 || gathered >= direct) refine_operator(p, gathered);
}

/// Whether the target is reached, or a budget forbids the round that `p` plans.
static bool is_over(const pursuit *p, rsv_error_stop *stop)
{
    const rsv_solve_report *report = rsv_solution_report(p->solution);
    double elements = (double)(report->elements + report->direct_elements);
    double planned =
        rsv_team_largest(p->context, rsv_seconds() - p->started + p->cost * p->round_seconds);
    if (relative(p, p->certificate->error_estimate_ci95[1]) <= p->target->relative_error)
        *stop = RSV_ERROR_TARGET_REACHED;
    else if (p->rounds >= p->target->max_rounds)
        *stop = RSV_ERROR_TARGET_MAX_ROUNDS;
    else if (p->size * elements > (double)p->target->max_elements)
        *stop = RSV_ERROR_TARGET_MAX_ELEMENTS;
    else if (planned > p->target->max_seconds)
        *stop = RSV_ERROR_TARGET_MAX_SECONDS;
    else
        return false;
    return true;
}

static void say_what_stopped(const pursuit *p, rsv_error_stop stop)
{
    static const char *const budget[] = { "", "elements (max_elements)", "time (max_seconds)",
        "rounds (max_rounds)" };
    if (stop == RSV_ERROR_TARGET_REACHED) return;
    rsv_log(p->context, RSV_LOG_WARNING,
        "error target: %.3g %% was not reached, the budget of %s ends at %.3g %%",
        100 * p->target->relative_error, budget[stop],
        100 * relative(p, p->certificate->error_estimate_ci95[1]));
}

rsv_status rsv_solve_to_error(const rsv_scene *scene, const rsv_solve_desc *start,
    const rsv_error_target *target, rsv_solution **solution, rsv_certificate *certificate,
    rsv_error_stop *stop)
{
    rsv_status status;
    pursuit p = { .scene = scene,
        .target = target,
        .context = rsv_scene_get_context(scene),
        .started = rsv_seconds(),
        .desc = start ? *start : rsv_default_solve_desc(RSV_QUALITY_DRAFT),
        .certify = rsv_default_certify_desc(),
        .certificate = certificate };
    p.certify.samples = FIRST_SAMPLES;
    p.certify.seed = p.desc.seed;
    RSV_TRY(check_target(target));
    do {
        RSV_TRY(build_round(&p));
        choose_refinement(&p);
    } while (!is_over(&p, stop));
    say_what_stopped(&p, *stop);
    *solution = p.solution;
    p.solution = NULL;
cleanup:
    rsv_solution_destroy(p.solution);
    return status;
}
