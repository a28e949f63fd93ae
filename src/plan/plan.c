/// Plans by error. Everything follows from the picture's size, the target error and the pilots. No clock is read, so a
/// plan is the same on every machine.
#include "../core/descriptor.h"
#include "../scene/scene.h"
#include "pixel_error.h"
#include "planner.h"

#include <math.h>
#include <stdio.h>

/// The settings of quality `draft` suit a picture with this many pixels and this relative MSE. Smaller pictures show
/// less of the elements' error, which decreases with their number; the error of their rays decreases with the rays.
#define USUAL_ELEMENTS 3000
#define USUAL_PIXELS 32400.0
#define USUAL_ERROR 0.005
#define USUAL_RAYS 128
#define LEAST_ELEMENTS 500.0
#define MOST_ELEMENTS 1e6
#define LEAST_RAYS 64
#define MOST_RAYS 1024
/// Noise of rows lies in blotches, which the eye sees before grain of the same size. Rows that have fewer rays than
/// this for each pixel cost less than the picture: they get more of them. Pictures with more noise than usual may have
/// fewer in proportion.
#define ROW_RAYS_PER_PIXEL 20.0
/// Bound of what the solver leaves, relative to the mean irradiance, for a relative error of 1. The bound is of the
/// worst place, several times what others have.
#define SOLVER_SHARE 0.01
/// Light paths for caustics, and fraction of the usual elements at contacts, that suit this error. The noise of
/// caustics decreases with the paths. The error at contacts, which are along lines, decreases with the root of their
/// elements.
#define USUAL_PHOTONS 250000
#define USUAL_CONTACTS 0.6
#define LEAST_PHOTONS 40000.0
#define MOST_PHOTONS 6e6
/// Below this error, pilots for curved light and a search for what the camera does not see are worthwhile, except in
/// simple scenes, of fewer triangles than elements: these begin with elements and rows for this error, or EASED times
/// the target, and the look at elements decides whether they are enough. cornell-blocks at 160x160 for 0.001 took 3.9 s
/// with pilots, 512 rays and a goal camera, 2.0 s without, at the same error (0.0011). For 0.000225, where the look
/// decides nothing, beginning at 0.002 left 0.0003. In the modern hall (28,655 triangles) at 160x90 for 0.0009, such a
/// beginning left 0.0017 instead of 0.0012 in the same time.
#define DEMANDING 0.002
#define EASED 4.0
#define REFINEMENTS 3
/// Fraction of the target error for elements. The noise of samples may always use this fraction, because samples are
/// cheaper than elements.
#define ELEMENTS_SHARE 0.75
#define LEAST_NOISE_SHARE 0.25
/// Fraction that elements are assumed to use if their error is not estimated (cornell-blocks: 0.12 to 0.17).
#define UNSEEN_ELEMENTS_SHARE 0.2
/// Cost of a camera ray with a gather ray, and of one without, in rays of rows, all included. Measured in the white
/// room and the Japanese classroom: 0.6 to 1.7 us for a ray of rows, 13 and 9 us for a camera ray.
#define GATHERED_COST 20.0
#define SAMPLE_COST 14.0
/// Fraction of the error of elements that gather rays leave, because only the first order of indirect light is
/// gathered. In cornell-blocks with 40 elements, 0.0015 is left; in two-rooms at draft, 0.0013 of 0.009.
#define GATHERED_LEFT 0.2
/// A finer solution has so many times the elements as its error is too large, times REFINED_BY, within these limits. Its
/// rows have twice the rays if the error is too large by more than RAYS_EXCESS. In the Japanese classroom, three times
/// the elements with the same rays left a fifth of the error; a third round of pilots on top of that took 2.5 times the
/// rays and left no less. A round that leaves more than LEAST_PROGRESS of the error has not helped.
#define LEAST_REFINEMENT 2.0
#define MOST_REFINEMENT 4.0
#define REFINED_BY 1.5
#define RAYS_EXCESS 3.0
#define LEAST_PROGRESS 0.8
#define MOST_ROUNDS 3
/// The error of elements is estimated by gathering at the first camera rays, and at more if that leaves more than
/// DOUBTFUL_SHARE of the target error uncertain: up to MOST_LOOKS per pixel in each of two passes, or this part of the
/// samples if that is more. It is not estimated for targets above GENEROUS, because that would take longer than the
/// picture. Measured: studio at 5 %, 17 samples per pixel: two estimates with 8 took 40 % of the whole.
#define LOOKS_SHARE 8
#define MOST_LOOKS 4
#define DOUBTFUL_SHARE 0.25
#define GENEROUS (2 * USUAL_ERROR)
#define MOST_SAMPLES 4096
/// Maximum weight of one place in an estimate of elements, and maximum number of pixels over which it is averaged.
#define MOST_OF_A_PLACE 4
#define MOST_AROUND 2
/// Estimates that exceed the target by less than this count as reaching it.
#define TOLERANCE 1.15

void rsv_plan_desc_init(rsv_plan_desc *desc, size_t size)
{
    const rsv_plan_desc defaults = {
        .size = sizeof defaults, .relative_error = 0.07, .max_seconds = INFINITY
    };
    rsv_desc_fill(desc, size, &defaults);
}

// ---- steps ----------------------------------------------------------------------------------------

rsv_status rsv_planner_solve(rsv_planner *p)
{
    rsv_light *light = NULL;
    rsv_status status = rsv_light_create(p->scene, &p->solve, &light);
    if (status != RSV_OK) return status;
    rsv_picture_series_destroy(p->series);
    p->series = NULL;
    rsv_light_destroy(p->light);
    p->light = light;
    p->plan.element_target = p->solve.element_target;
    p->plan.rays_per_element = rsv_light_report(light)->rays_per_row;
    p->plan.refinements = p->solve.refinements;
    p->plan.goal = p->solve.goal_camera != RSV_NONE;
    p->plan.rounds++;
    return RSV_OK;
}

/// Power of the samples with which squared errors fall.
static double fall_of(const rsv_planner *p)
{
    return p->plan.gathers ? RSV_GATHERED_FALL : RSV_STRATIFIED_FALL;
}

/// @param count [height * width] samples of each pixel, not of path traced ones; NULL = the same in all
static rsv_status take(rsv_planner *p, uint32_t samples, const uint32_t *count, rsv_image **image)
{
    rsv_render_desc desc = p->picture;
    desc.samples = samples;
    desc.seed += 0x9e3779b9u * p->passes++; // the first pass has the seed itself
    RSV_ASSERT(!count || desc.mode != RSV_RENDER_REFERENCE);
    if (desc.mode == RSV_RENDER_REFERENCE)
        return rsv_render_reference(p->scene, &desc, image, NULL);
    rsv_status status = RSV_OK;
    if (!p->series) status = rsv_picture_series_create(p->light, &desc, &p->series);
    return status == RSV_OK ? rsv_picture_series_take(p->series, &desc, count, image) : status;
}

rsv_status rsv_planner_take(rsv_planner *p, uint32_t samples)
{
    rsv_image *pass = NULL;
    rsv_status status = take(p, samples, NULL, &pass);
    return status == RSV_OK ? rsv_sample_sum_add(p->context, &p->sum, samples, pass) : status;
}

rsv_status rsv_planner_take_allocated(rsv_planner *p, const rsv_allocation *allocation)
{
    rsv_image *pass = NULL;
    uint32_t samples = (uint32_t)fmax(allocation->mean + 0.5, 1);
    rsv_status status = take(p, samples, allocation->extra, &pass);
    if (status == RSV_OK)
        status = rsv_sample_sum_add_uneven(p->context, &p->sum, allocation->extra, pass);
    if (status == RSV_OK) p->plan.noise = allocation->noise;
    return status;
}

// ---- sufficient settings -------------------------------------------------------------------------

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

/// Factors of the next solution.
typedef struct refinement {
    double elements;
    uint32_t rays; ///< of each row
} refinement;

static refinement next_refinement(const rsv_planner *p)
{
    double excess = p->plan.elements_error / (ELEMENTS_SHARE * p->wanted);
    bool needs_rays = excess > RAYS_EXCESS && p->solve.rays_per_element < MOST_RAYS;
    return (refinement){ fmin(fmax(REFINED_BY * excess, LEAST_REFINEMENT), MOST_REFINEMENT),
        needs_rays ? 2 : 1 };
}

static void choose_finer(rsv_planner *p)
{
    refinement next = next_refinement(p);
    p->solve.element_target =
        (uint32_t)fmin((double)p->solve.element_target * next.elements, MOST_ELEMENTS);
    p->solve.rays_per_element *= next.rays;
    p->solve.photon_count = (uint32_t)fmin(2.0 * p->solve.photon_count, MOST_PHOTONS);
    p->solve.contact_share = fminf(2 * p->solve.contact_share, 1);
    if (!p->picture.viewpoint && p->picture.film.projection == RSV_PROJECTION_CAMERA)
        p->solve.goal_camera = p->picture.camera;
}

/// Errors of elements extend over areas of their own size. One gather ray per pixel mostly misses a small bright
/// caustic, and its few hits outweigh everything else, so averages must include a few of them in most places.
static rsv_pixel_error_desc about_elements(const rsv_planner *p)
{
    double pixels = (double)p->picture.width * p->picture.height;
    double edge = sqrt(pixels / p->solve.element_target);
    return (rsv_pixel_error_desc){ MOST_OF_A_PLACE, (uint32_t)fmin(fmax(edge / 2, 1), MOST_AROUND),
        true };
}

/// Two more passes, one for each half of the sum.
static rsv_status take_pair(rsv_planner *p, uint32_t samples, rsv_sample_sum *sum)
{
    rsv_image *pass[2] = { NULL, NULL };
    rsv_status status = take(p, samples, NULL, &pass[0]);
    if (status == RSV_OK) status = take(p, samples, NULL, &pass[1]);
    if (status == RSV_OK) return rsv_sample_sum_add_pair(p->context, sum, samples, pass);
    rsv_image_destroy(pass[0]);
    return status;
}

/// Two passes, which show the noise.
static rsv_status take_first(rsv_planner *p)
{
    uint32_t samples = p->wanted > GENEROUS ? 1 : 2;
    rsv_sample_sum_clear(p->context, &p->sum);
    rsv_status status = take_pair(p, samples, &p->sum);
    if (status == RSV_OK) p->plan.noise = rsv_sample_sum_noise(&p->sum, fall_of(p));
    return status;
}

/// Repeats two passes with a gather ray per camera ray. All other random numbers are the same, so that edges,
/// highlights and shadows add no noise to the differences. @param number of the first of them
static rsv_status take_gathered(rsv_planner *p, uint32_t number, uint32_t samples)
{
    uint32_t passes = p->passes;
    p->passes = number;
    p->picture.gather_rays = 1;
    rsv_status status = take_pair(p, samples, &p->gathered);
    p->picture.gather_rays = 0;
    p->passes = passes;
    return status;
}

/// Compares the two halves with those of one more gather through the solution. The difference, apart from noise, is the
/// elements' error.
static void compare_halves(rsv_planner *p, double *uncertainty)
{
    const rsv_image *const stored[2] = { p->sum.half[0], p->sum.half[1] };
    const rsv_image *const truth[2] = { p->gathered.half[0], p->gathered.half[1] };
    rsv_pixel_error_desc desc = about_elements(p);
    double error = rsv_pixel_error(stored, truth, desc, uncertainty);
    double factor = rsv_pixel_error_averaged_away(stored, truth, desc, error, *uncertainty);
    p->plan.elements_error = factor * fmax(error, 0);
    *uncertainty *= factor;
}

/// Relative MSE by elements: as was found, or as is usual.
static double known_elements_error(const rsv_planner *p)
{
    double found = p->plan.elements_error;
    return isnan(found) ? UNSEEN_ELEMENTS_SHARE * p->wanted : found;
}

/// Relative MSE that is left for the noise of samples.
static double noise_allowed(const rsv_planner *p)
{
    return fmax(p->wanted - known_elements_error(p), LEAST_NOISE_SHARE * p->wanted);
}

static uint32_t samples_needed(const rsv_planner *p)
{
    return rsv_samples_for(
        p->plan.noise / noise_allowed(p), p->sum.samples, fall_of(p), MOST_SAMPLES);
}

/// Estimates the error of elements, more accurately if that does not decide whether they are good enough.
static rsv_status judge_elements(rsv_planner *p, double *uncertainty)
{
    uint32_t taken = p->sum.half_samples, number = p->passes;
    rsv_sample_sum_clear(p->context, &p->gathered);
    rsv_status status = take_gathered(p, number - 2, taken);
    if (status != RSV_OK) return status;
    compare_halves(p, uncertainty);
    double doubt = *uncertainty / (DOUBTFUL_SHARE * p->wanted);
    double most = fmax(MOST_LOOKS, samples_needed(p) / LOOKS_SHARE);
    uint32_t samples = (uint32_t)fmin(ceil(doubt * taken), most);
    if (samples <= taken) return RSV_OK;
    status = take_pair(p, samples - taken, &p->sum);
    if (status == RSV_OK) status = take_gathered(p, number, samples - taken);
    if (status != RSV_OK) return status;
    p->plan.noise = rsv_sample_sum_noise(&p->sum, fall_of(p));
    compare_halves(p, uncertainty);
    return RSV_OK;
}

/// Whether gather rays reach the target error sooner than a finer solution, or are the only way.
static bool is_gathering_better(const rsv_planner *p, bool is_last)
{
    double pixels = (double)p->picture.width * p->picture.height;
    double noise = rsv_sample_sum_noise(&p->gathered, RSV_GATHERED_FALL);
    uint32_t taken = p->gathered.samples;
    uint32_t gathered = rsv_samples_for(noise / p->wanted, taken, RSV_GATHERED_FALL, MOST_SAMPLES);
    if (is_last) return gathered < MOST_SAMPLES;
    uint32_t looked_up = rsv_samples_for(
        p->plan.noise / p->wanted, p->sum.samples, RSV_STRATIFIED_FALL, MOST_SAMPLES);
    refinement next = next_refinement(p);
    double rows = next.elements * next.rays * (double)rsv_light_report(p->light)->row_rays;
    double further = gathered > taken ? (double)(gathered - taken) : 0;
    return further * GATHERED_COST * pixels < rows + (double)looked_up * SAMPLE_COST * pixels;
}

/// The look at elements becomes the picture.
static void begin_gathering(rsv_planner *p)
{
    rsv_sample_sum_clear(p->context, &p->sum);
    p->sum = p->gathered;
    p->gathered = (rsv_sample_sum){ 0 };
    p->picture.gather_rays = 1;
    p->plan.gathers = true;
    p->plan.noise = rsv_sample_sum_noise(&p->sum, fall_of(p));
    p->plan.elements_error *= GATHERED_LEFT;
    p->uncertainty *= GATHERED_LEFT;
}

/// Refines elements while they limit the picture, it helps, and gather rays would take longer.
static rsv_status find_solution(rsv_planner *p)
{
    rsv_status status = p->light ? RSV_OK : rsv_planner_solve(p);
    double before = INFINITY;
    while (status == RSV_OK) {
        p->plan.elements_error = NAN;
        status = take_first(p);
        if (status != RSV_OK || p->wanted > GENEROUS) break;
        status = judge_elements(p, &p->uncertainty);
        double least = p->plan.elements_error - p->uncertainty; // more than chance
        if (status != RSV_OK || least <= ELEMENTS_SHARE * p->wanted) break;
        bool is_last = p->is_given || p->plan.rounds >= MOST_ROUNDS ||
                       p->plan.elements_error > LEAST_PROGRESS * before;
        if (is_gathering_better(p, is_last)) begin_gathering(p);
        if (is_last || p->plan.gathers) break;
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
    // direct light is the pixels' own: such elements hold caustics, which a look takes from them too
    const char *unknown =
        report->direct_elements ? "; the error of stored caustics is not known" : "";
    rsv_log(p->context, RSV_LOG_INFO,
        "plan: %zu rows%s%s and %u camera rays per pixel%s for a relative error of %.2g "
        "%%%s%s",
        report->rows, rays, plan->goal ? " for this camera" : "", samples,
        plan->gathers ? ", with a gather ray each," : "", 100 * sqrt(p->wanted), elements, unknown);
}

static void say_what_is_missing(const rsv_planner *p)
{
    double elements = known_elements_error(p);
    rsv_log(p->context, RSV_LOG_WARNING,
        "plan: a relative error of %.2g %% cannot be reached: about %.2g %% is likely, %.2g %% due to elements "
        "and %.2g %% due to samples; request a larger error, or use --quality high",
        100 * sqrt(p->wanted), 100 * sqrt(elements + p->plan.noise), 100 * sqrt(elements),
        100 * sqrt(p->plan.noise));
}

static rsv_status run_to_error(rsv_planner *p)
{
    rsv_status status;
    rsv_allocation allocation = { 0 };
    choose_elements(p);
    RSV_TRY(find_solution(p));
    RSV_TRY(rsv_allocate_samples(
        p->context, &p->sum, fall_of(p), noise_allowed(p), MOST_SAMPLES, &allocation));
    say_plan(p, p->sum.samples + (uint32_t)(allocation.mean + 0.5));
    if (allocation.mean > 0) RSV_TRY(rsv_planner_take_allocated(p, &allocation));
    double error = known_elements_error(p) + p->plan.noise;
    p->plan.is_reached = error <= TOLERANCE * TOLERANCE * p->wanted;
    if (!p->plan.is_reached) say_what_is_missing(p);
cleanup:
    rsv_allocation_clear(p->context, &allocation);
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
    status = isfinite(settings.max_seconds) ? rsv_planner_run_until(&p, settings.max_seconds)
                                            : run_to_error(&p);
    rsv_picture_series_destroy(p.series);
    if (status == RSV_OK) {
        p.plan.samples = p.sum.samples;
        if (plan) *plan = p.plan;
        *image = p.sum.mean;
        p.sum.mean = NULL;
        *light = p.light;
    } else if (!p.is_given) {
        rsv_light_destroy(p.light);
    }
    rsv_sample_sum_clear(p.context, &p.sum);
    rsv_sample_sum_clear(p.context, &p.gathered);
    return status;
}
