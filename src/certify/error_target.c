/// Refinement until the certificate is content.
#include "../core/descriptor.h"
#include "../core/sampling.h"
#include "../core/team.h"
#include "resolvent/certify.h"

#include <math.h>

/// Rounds aim this far below the target, so that the interval fits below it too.
#define AIM 0.75
/// The default target.
#define DEFAULT_ERROR 0.05
/// A round multiplies elements and samples by the first of these at most, by a later one where time is short.
static const double largest_step[] = { 4, 2, 1.25 };
enum { STEPS = 3 };
/// Rounds may take up to this many times their planned time.
#define DOUBT 1.5
/// From steps of this size on, rays grow along with elements.
#define RAYS_STEP 1.5
/// Elements of the direct level for each of the coarse ones, at most.
#define MOST_DIRECT_PER_ROW 16
#define MOST_RAYS 4096
#define MOST_LIGHT_SAMPLES 4096
#define MOST_DIRECT_LEVELS 8
#define MOST_PHOTONS 500000000u
#define REFINEMENTS 3
/// A round that leaves more than this fraction of the lowest error so far has not helped; this many in a row end the
/// rounds.
#define LEAST_PROGRESS 0.9
#define IDLE_ROUNDS 2
/// A certificate that is undecided, or must be confirmed, gets more points: from the first number up to the second.
#define FIRST_SAMPLES 512
#define MOST_SAMPLES 65536
#define MORE_POINTS 4
#define SEED_OF_MORE_POINTS 0x2b7e1516u

/// A solution that was made and certified.
typedef struct attempt {
    rsv_light *solution; ///< NULL = none is kept: the description makes it again
    rsv_solve_desc desc;
    rsv_certificate certificate;
    double upper;
} attempt;

typedef struct pursuit {
    const rsv_scene *scene;
    const rsv_error_target *target;
    rsv_context *context;
    double started, round_started, round_seconds;
    rsv_solve_desc desc; ///< of the present round
    rsv_certify_desc certify;
    rsv_light *solution;
    rsv_certificate *certificate;
    double error, upper;    ///< relative: the present solution's, and the upper end of its interval
    bool confirmed;         ///< by other points: that the target is reached
    double certify_seconds; ///< of the last certificate
    attempt best;           ///< so far; may be the present one
    double lowest;          ///< error so far
    uint32_t rounds, idle;
    double cost;        ///< of the next round over the present one
    double size;        ///< planned number of rows
    double direct_size; ///< planned number of direct elements
} pursuit;

void rsv_error_target_init(rsv_error_target *desc, size_t size, double relative_error)
{
    const rsv_error_target defaults = { .size = sizeof defaults,
        .relative_error = relative_error,
        .max_elements = 5000000,
        .max_seconds = INFINITY,
        .max_rounds = 8 };
    rsv_desc_fill(desc, size, &defaults);
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

static bool is_aimed(const pursuit *p)
{
    return p->desc.goal_point_count > 0 || p->desc.goal_camera != RSV_NONE;
}

/// Where the solution is dark, any error counts as infinite.
static double relative(double error, double light)
{
    return light > 0 ? error / light : error > 0 ? INFINITY : 0;
}

/// Of the goal's reading, where there is a goal.
static rsv_status certify_goal(pursuit *p)
{
    const rsv_solve_desc *d = &p->desc;
    rsv_goal_certificate g;
    rsv_status status = RSV_OK;
    if (!is_aimed(p)) return RSV_OK;
    if (d->goal_point_count > 0)
        status =
            rsv_certify_points(p->solution, &p->certify, d->goal_points, d->goal_point_count, &g);
    else
        status = rsv_certify_goal(p->solution, &p->certify, d->goal_camera, &g);
    if (status != RSV_OK) return status;
    double upper = fmax(fabs(g.error_ci95[0]), fabs(g.error_ci95[1]));
    p->error = relative(fabs(g.error), g.reading);
    p->upper = relative(upper, g.reading);
    return RSV_OK;
}

static rsv_status certify(pursuit *p)
{
    double start = rsv_seconds();
    rsv_status status = rsv_certify(p->solution, &p->certify, p->certificate);
    double light = p->certificate->irradiance_rms;
    p->error = relative(p->certificate->error_estimate_rms, light);
    p->upper = relative(p->certificate->error_estimate_ci95[1], light);
    if (status == RSV_OK) status = certify_goal(p);
    p->certify_seconds = rsv_seconds() - start;
    return status;
}

static bool is_below_target(const pursuit *p) { return p->upper <= p->target->relative_error; }

/// Whether only the number of points keeps the interval above the target, and more are allowed.
static bool is_undecided(const pursuit *p)
{
    return p->error < AIM * p->target->relative_error && !is_below_target(p) &&
           p->certify.samples < MOST_SAMPLES;
}

/// As the slowest process sees it.
static bool has_time_for_more_points(const pursuit *p)
{
    double end = rsv_seconds() - p->started + MORE_POINTS * p->certify_seconds;
    return rsv_team_largest(p->context, end) <= p->target->max_seconds;
}

static void take_more_points(rsv_certify_desc *certify)
{
    certify->samples = certify->samples < MOST_SAMPLES / MORE_POINTS
                           ? certify->samples * MORE_POINTS
                           : MOST_SAMPLES;
    certify->seed = rsv_hash2(certify->seed, SEED_OF_MORE_POINTS);
}

/// Certifies again with more and other points, as long as these keep the interval above the target, and once more if it
/// is below: one of many looks might be lucky, and a few points may have missed much.
static rsv_status certify_decisively(pursuit *p)
{
    p->certify.samples = FIRST_SAMPLES;
    for (bool confirms = false;; take_more_points(&p->certify)) {
        rsv_status status = certify(p);
        if (status != RSV_OK) return status;
        p->confirmed = confirms && is_below_target(p);
        confirms = is_below_target(p);
        bool enough = confirms ? p->confirmed : !is_undecided(p);
        if (enough || !has_time_for_more_points(p)) return RSV_OK;
    }
}

/// Frees the present solution, unless it is the best one and memory suffices.
static void let_go(pursuit *p)
{
    if (p->solution != p->best.solution) rsv_light_destroy(p->solution);
    p->solution = NULL;
    if (p->desc.max_bytes == 0) return;
    rsv_light_destroy(p->best.solution);
    p->best.solution = NULL;
}

/// Records whether the round has helped, and keeps the best solution: one that reaches the target, or the one with the
/// lowest error.
static void judge_round(pursuit *p)
{
    bool helped = p->rounds == 0 || p->error <= LEAST_PROGRESS * p->lowest;
    p->idle = helped ? 0 : p->idle + 1;
    p->lowest = p->rounds == 0 ? p->error : fmin(p->lowest, p->error);
    if (p->rounds > 0 && !p->confirmed && p->upper >= p->best.upper) return;
    rsv_light_destroy(p->best.solution);
    p->best = (attempt){ p->solution, p->desc, *p->certificate, p->upper };
}

static rsv_status build_round(pursuit *p)
{
    p->round_started = rsv_seconds();
    let_go(p);
    rsv_status status = rsv_light_create(p->scene, &p->desc, &p->solution);
    if (status == RSV_OK) status = certify_decisively(p);
    if (status != RSV_OK) return status;
    judge_round(p);
    p->rounds++;
    p->round_seconds = rsv_seconds() - p->round_started;
    const rsv_solve_report *report = rsv_light_report(p->solution);
    rsv_log(p->context, RSV_LOG_INFO,
        "error target: %.3g %% (95 %%: up to %.3g %%) with %zu elements and %u rays each",
        100 * p->error, 100 * p->upper, report->elements + report->direct_elements,
        p->desc.rays_per_element);
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
static void refine_direct(pursuit *p, double excess, double largest)
{
    double step = fmin(excess * excess, largest);
    p->desc.direct_levels += p->desc.direct_levels < MOST_DIRECT_LEVELS;
    p->desc.light_samples = doubled(p->desc.light_samples, step, MOST_LIGHT_SAMPLES);
    p->cost *= 2;
    p->direct_size *= 2;
}

/// Noise falls with the root of the rays, interpolation with the area of elements: both get the same share.
static void refine_operator(pursuit *p, double excess, double largest)
{
    double step = fmin(fmax(excess * excess, RAYS_STEP), largest);
    uint32_t rays = p->desc.rays_per_element;
    p->desc.element_target = grown(p->desc.element_target, step, UINT32_MAX);
    if (step >= RAYS_STEP) p->desc.rays_per_element = doubled(rays, step, MOST_RAYS);
    p->desc.photon_count = grown(p->desc.photon_count, 2 * step, MOST_PHOTONS);
    if (p->desc.refinements < REFINEMENTS) p->desc.refinements++;
    p->cost *= step * p->desc.rays_per_element / rays;
    p->size *= step;
}

/// Refines the parts of the residual that alone would use more than half of the allowed error, or at least the larger
/// one. After a round that has not helped, both: shadows narrower than their cells need finer elements to be seen.
static void choose_refinement(pursuit *p, double largest)
{
    const rsv_certificate *c = p->certificate;
    double allowed = AIM * p->target->relative_error * c->irradiance_rms;
    // reflections make more of a residual than it was
    double gain = c->residual_rms > 0 ? fmax(c->error_estimate_rms / c->residual_rms, 0.5) : 1;
    // a goal may lack more or less than surfaces do in the mean
    double all = relative(c->error_estimate_rms, c->irradiance_rms);
    double lacking = fmax(p->error, p->upper / 2);
    if (is_aimed(p) && all > 0 && isfinite(all) && isfinite(lacking)) gain *= lacking / all;
    double direct = gain * c->residual_direct_rms / (M_SQRT1_2 * allowed);
    double gathered = gain * c->residual_gathered_rms / (M_SQRT1_2 * allowed);
    p->cost = p->size = p->direct_size = 1;
    bool both = p->idle > 0;
    if (both || direct > 1 || direct > gathered) refine_direct(p, direct, largest);
    if (both || gathered > 1 || gathered >= direct)
        refine_operator(p, both ? fmax(gathered, direct) : gathered, largest);
}

/// Seconds after the next round, of the slowest process.
static double planned_seconds(const pursuit *p)
{
    double round = DOUBT * p->cost * p->round_seconds;
    return rsv_team_largest(p->context, rsv_seconds() - p->started + round);
}

/// The largest step for which there is time.
static void plan_round(pursuit *p)
{
    const rsv_solve_desc present = p->desc;
    for (int k = 0; k < STEPS; k++) {
        p->desc = present;
        choose_refinement(p, largest_step[k]);
        if (planned_seconds(p) <= p->target->max_seconds) return;
    }
}

static bool stop_for(rsv_error_stop reason, rsv_error_stop *stop)
{
    *stop = reason;
    return true;
}

/// Whether the target is reached, or a budget forbids the round that `p` plans.
static bool is_over(const pursuit *p, rsv_error_stop *stop)
{
    const rsv_solve_report *report = rsv_light_report(p->solution);
    double most = (double)p->target->max_elements, rows = p->size * (double)report->rows;
    double direct = p->direct_size * (double)report->direct_elements;
    double planned = planned_seconds(p);
    if (p->confirmed) return stop_for(RSV_ERROR_TARGET_REACHED, stop);
    // there was no time to confirm it
    if (is_below_target(p)) return stop_for(RSV_ERROR_TARGET_MAX_SECONDS, stop);
    if (p->idle >= IDLE_ROUNDS) return stop_for(RSV_ERROR_TARGET_STALLED, stop);
    if (p->rounds >= p->target->max_rounds) return stop_for(RSV_ERROR_TARGET_MAX_ROUNDS, stop);
    if (rows > most || direct > MOST_DIRECT_PER_ROW * most)
        return stop_for(RSV_ERROR_TARGET_MAX_ELEMENTS, stop);
    return planned > p->target->max_seconds && stop_for(RSV_ERROR_TARGET_MAX_SECONDS, stop);
}

static void say_what_stopped(const pursuit *p, rsv_error_stop stop)
{
    static const char *const budget[] = { "", "elements", "time", "rounds", "" };
    const rsv_certificate *c = &p->best.certificate;
    bool direct = c->residual_direct_rms > c->residual_gathered_rms;
    if (stop == RSV_ERROR_TARGET_REACHED) return;
    if (stop == RSV_ERROR_TARGET_STALLED) {
        rsv_log(p->context, RSV_LOG_WARNING,
            "error target: %.3g %% was not reached: %d rounds of refinement in a row have hardly "
            "lowered the error; the smallest is %.3g %%, mostly due to %s; `resolvent certify "
            "--heatmap` shows where",
            100 * p->target->relative_error, IDLE_ROUNDS, 100 * p->best.upper,
            direct ? "direct light" : "indirect light, gathered sources or caustics");
        return;
    }
    if (is_below_target(p)) {
        rsv_log(p->context, RSV_LOG_WARNING,
            "error target: few points show up to %.3g %%; the time budget ends before more points "
            "can confirm it",
            100 * p->upper);
        return;
    }
    rsv_log(p->context, RSV_LOG_WARNING,
        "error target: %.3g %% was not reached; the budget of %s was used up at %.3g %%",
        100 * p->target->relative_error, budget[stop], 100 * p->best.upper);
}

/// Hands over the best solution, made once more where it was not kept.
static rsv_status hand_over(pursuit *p, rsv_light **solution)
{
    rsv_status status = RSV_OK;
    if (!p->best.solution) {
        let_go(p);
        status = rsv_light_create(p->scene, &p->best.desc, &p->best.solution);
    }
    if (status != RSV_OK) return status;
    if (p->solution != p->best.solution) rsv_light_destroy(p->solution);
    *p->certificate = p->best.certificate;
    *solution = p->best.solution;
    p->solution = p->best.solution = NULL;
    return status;
}

rsv_status rsv_solve_to_error(const rsv_scene *scene, const rsv_solve_desc *start,
    const rsv_error_target *target, rsv_light **solution, rsv_certificate *certificate,
    rsv_error_stop *stop)
{
    rsv_status status;
    rsv_error_target wanted = rsv_default_error_target(DEFAULT_ERROR);
    pursuit p = { .scene = scene,
        .target = &wanted,
        .context = rsv_scene_get_context(scene),
        .started = rsv_seconds(),
        .desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT),
        .certify = rsv_default_certify_desc(),
        .certificate = certificate };
    RSV_TRY(RSV_READ_DESC(rsv_solve_desc, &p.desc, start));
    RSV_TRY(RSV_READ_DESC(rsv_error_target, &wanted, target));
    RSV_TRY(check_target(&wanted));
    p.certify.seed = p.desc.seed;
    do {
        RSV_TRY(build_round(&p));
        plan_round(&p);
    } while (!is_over(&p, stop));
    say_what_stopped(&p, *stop);
    RSV_TRY(hand_over(&p, solution));
cleanup:
    if (p.solution != p.best.solution) rsv_light_destroy(p.solution);
    rsv_light_destroy(p.best.solution);
    return status;
}
