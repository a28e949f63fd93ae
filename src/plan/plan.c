/// Plans by error. Everything follows from the picture's size, the target error and the pilots. No clock is read, so a
/// plan is the same on every machine.
#include "../core/descriptor.h"
#include "../core/sampling.h"
#include "../scene/scene.h"
#include "pixel_error.h"
#include "planner.h"
#include "selection.h"
#include "spots.h"

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
/// Fraction of the target error that elements may cause in any case. The noise of samples may always use this fraction,
/// because samples are cheaper than elements.
#define ELEMENTS_SHARE 0.75
#define LEAST_NOISE_SHARE 0.2
/// The same in pictures that are filtered, where what is left is hard to get rid of: in the classroom, 220 samples
/// instead of 135 took 50 of 190 CPU s, and the error was mostly due to elements.
#define LEAST_FILTERED_NOISE_SHARE 0.5
/// Fraction of the target error that elements usually cause, and its standard deviation: 0.1 in cornell-blocks, 0.3 in
/// the modern hall, 1 in the staircase and the white room. Estimates count as far as they are more certain.
#define USUAL_ELEMENTS_SHARE 0.3
#define ELEMENTS_SHARE_SPREAD 0.5
/// Least fraction in pictures that are filtered. It is not worthwhile to know it better there: a longer look would take
/// as long as the picture, and samples are few. In the hall, the staircase, the white room and the classroom at 320x180
/// and 7 %, pictures whose noise was to be all of the target had 0.7, 2.4, 2.1 and 3.1 times the squared error requested.
#define FILTERED_ELEMENTS_SHARE 0.5
/// Cost of a camera ray with a gather ray, and of one without, in rays of rows, all included. Measured in the white
/// room and the Japanese classroom: 0.6 to 1.7 us for a ray of rows, 13 and 9 us for a camera ray.
#define GATHERED_COST 20.0
#define SAMPLE_COST 14.0
/// Cost of a row beside its rays, in rays: elements, pilots, solver. Measured in the modern hall and the white room at
/// draft: 0.9 and 1.3 ms.
#define ROW_COST 1000.0
/// An error beyond the target makes a remedy so much dearer: it is accepted where others cost several times as much.
#define EXCESS_POWER 4
/// Fraction of the error of elements that gather rays leave, because only the first order of indirect light is
/// gathered. In cornell-blocks with 40 elements, 0.0015 is left; in two-rooms at draft, 0.0013 of 0.009.
#define GATHERED_LEFT 0.2
/// Part of the noise of gather rays that the filter leaves: white room, 4 camera rays, relative MSE 0.19 without it and
/// 0.025 with it, of which the elements have 0.006.
#define FILTERED_GATHERING 0.2
/// The light that gather rays come to has a part of the same error, so that stored light differs less from gathered
/// light than from the truth. Relative MSE, stored against gathered and against the path tracer: gallery 0.0021 and
/// 0.0035, two-rooms 0.0095 and 0.0148, hall 0.0038 and 0.0060, staircase 0.0125 and 0.0174.
#define BEYOND_GATHERING 1.5
/// A finer solution has so many times the elements as its error is too large, times REFINED_BY, within these limits.
/// Its rows have twice the rays if the error is too large by more than RAYS_EXCESS. In the Japanese classroom, three
/// times the elements with the same rays left a fifth of the error; a third round of pilots on top of that took 2.5 times the
/// rays and left no less. A round that leaves more than LEAST_PROGRESS of the error has not helped: the next one has
/// STUCK_RAYS times the rays instead, with as many elements, and is the last if it does not help either.
#define LEAST_REFINEMENT 2.0
#define MOST_REFINEMENT 4.0
#define REFINED_BY 1.5
#define RAYS_EXCESS 3.0
#define LEAST_PROGRESS 0.8
#define STUCK_RAYS 4
/// Where elements err too much, pixels gather whose squared error is above this fraction of the target, if they are no
/// more than this share of the picture, with so many rays per camera ray. Japanese classroom, 160x90, for 0.0049: of an
/// error of 0.0092, 0.0038 is left where 6 % of the pixels gather, 0.0028 at 12 %, 0.0023 at 20 %.
#define SELECTED_ABOVE 0.2
#define MOST_SELECTED 0.5
#define SELECTED_RAYS 4
/// Gather rays that select pixels, and those of each camera ray at most.
#define SELECTING_RAYS 2e6
#define MOST_SELECTING_RAYS 8
#define MOST_ROUNDS 4
/// Between the seeds of pictures.
#define OTHER_SEED 0x9e3779b9u
/// Targets above this begin with one camera ray in each half, others with two.
#define GENEROUS (2 * USUAL_ERROR)
/// The error of elements is estimated at SPOTS pixels with FIRST_RAYS gather rays each. If that leaves more than
/// DOUBTFUL_SHARE of the target error uncertain, more rays follow at as many others, for up to LOOK_SHARE of the cost
/// of rows and samples. Few pixels have most of the error: 800 with 32 rays each cost about as much as 3200 with 8, but
/// by the spread of errors in the classroom leave .0018 uncertain, calculated, instead of .0010. GATHER_RAY_COST is that of a gather ray alone, like GATHERED_COST.
#define SPOTS 3200
#define FIRST_RAYS 8
#define LOOK_SHARE 0.3
#define GATHER_RAY_COST (GATHERED_COST - SAMPLE_COST)
#define DOUBTFUL_SHARE 0.25
#define MOST_SAMPLES 4096
/// Passes where the picture is noisy, and how far noise may exceed what is allowed after the first.
#define MOST_PASSES 8
#define RETAKE 1.1
/// Estimates of the relative error that exceed the target by less than this count as reaching it.
#define TOLERANCE 1.15

void rsv_plan_desc_init(rsv_plan_desc *desc, size_t size)
{
    const rsv_plan_desc defaults = {
        .size = sizeof defaults, .relative_error = 0.07, .max_seconds = INFINITY
    };
    rsv_desc_fill(desc, size, &defaults);
}

// ---- steps ----------------------------------------------------------------------------------------

static void forget_selection(rsv_planner *p)
{
    rsv_free(p->context, p->selected);
    p->selected = NULL;
    p->plan.gathered_share = 0;
}

rsv_status rsv_planner_solve(rsv_planner *p)
{
    rsv_light *light = NULL;
    rsv_status status = rsv_light_create(p->scene, &p->solve, &light);
    if (status != RSV_OK) return status;
    rsv_picture_series_destroy(p->series);
    p->series = NULL;
    forget_selection(p);
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
    return p->plan.gathers || p->selected ? RSV_GATHERED_FALL : RSV_STRATIFIED_FALL;
}

/// Takes one pass of a pair, which are the halves of one stratified picture.
/// @param samples of this pass, in each pixel or on average @param count [height * width] samples of each pixel in both
/// passes, not of path traced ones; NULL = the same in all
static rsv_status take(rsv_planner *p, uint32_t samples, const uint32_t *count, rsv_image **image)
{
    rsv_render_desc desc = p->picture;
    uint32_t index = p->passes++;
    RSV_ASSERT(!count || desc.mode != RSV_RENDER_REFERENCE);
    if (desc.mode == RSV_RENDER_REFERENCE) {
        desc.samples = samples;
        desc.seed += OTHER_SEED * index;
        return rsv_render_reference(p->scene, &desc, image, NULL);
    }
    rsv_picture_pass pass = {
        .count = count, .is_half = true, .half = index % 2, .is_alone = p->compares
    };
    rsv_status status = RSV_OK;
    desc.samples = 2 * samples;
    desc.seed += OTHER_SEED * (index / 2); // the first pair has the seed itself
    if (!p->series) status = rsv_picture_series_create(p->light, &desc, &p->series);
    if (status != RSV_OK) return status;
    if (!desc.gather_rays && p->selected) {
        pass.where = p->selected;
        desc.gather_rays = SELECTED_RAYS;
    }
    if (desc.gather_rays) pass.gathered = p->gathered;
    return rsv_picture_series_take(p->series, &desc, &pass, image);
}

rsv_status rsv_planner_take(rsv_planner *p, uint32_t samples)
{
    rsv_image *pass = NULL;
    rsv_status status = take(p, samples, NULL, &pass);
    return status == RSV_OK ? rsv_sample_sum_add(p->context, &p->sum, samples, pass) : status;
}

rsv_status rsv_planner_find_outlines(rsv_planner *p)
{
    size_t pixels = (size_t)p->picture.width * p->picture.height;
    if (!p->sum.is_outline)
        p->sum.is_outline = rsv_alloc(p->context, pixels, sizeof *p->sum.is_outline);
    if (!p->sum.is_outline) return RSV_ERROR_MEMORY;
    return rsv_picture_series_find_outlines(p->series, p->sum.mean, p->sum.is_outline);
}

rsv_status rsv_planner_take_allocated(rsv_planner *p, const rsv_allocation *allocation)
{
    uint32_t mean = (uint32_t)fmax(allocation->mean / 2 + 0.5, 1);
    rsv_image *pass[2] = { NULL, NULL };
    rsv_status status = RSV_OK;
    RSV_ASSERT(p->passes % 2 == 0);
    for (int half = 0; half < 2 && status == RSV_OK; half++)
        status = take(p, mean, allocation->extra, &pass[half]);
    if (status == RSV_OK) {
        const rsv_uneven_pair pair = { allocation->extra, allocation->renewed, allocation->fall };
        status = rsv_sample_sum_add_uneven(p->context, &p->sum, &pair, pass);
        if (status == RSV_OK)
            status = rsv_sample_sum_filter(p->context, &p->sum, allocation->fall);
    } else {
        rsv_image_destroy(pass[0]);
    }
    if (status == RSV_OK) p->plan.noise = rsv_uneven_noise(&p->sum);
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
    if (p->is_stuck)
        return (refinement){ 1, p->solve.rays_per_element < MOST_RAYS ? STUCK_RAYS : 1 };
    bool needs_rays = excess > RAYS_EXCESS && p->solve.rays_per_element < MOST_RAYS;
    return (refinement){ fmin(fmax(REFINED_BY * excess, LEAST_REFINEMENT), MOST_REFINEMENT),
        needs_rays ? 2 : 1 };
}

static void choose_finer(rsv_planner *p)
{
    refinement next = next_refinement(p);
    p->solve.element_target =
        (uint32_t)fmin((double)p->solve.element_target * next.elements, MOST_ELEMENTS);
    p->solve.rays_per_element = (uint32_t)fmin(p->solve.rays_per_element * next.rays, MOST_RAYS);
    p->solve.photon_count = (uint32_t)fmin(2.0 * p->solve.photon_count, MOST_PHOTONS);
    p->solve.contact_share = fminf(2 * p->solve.contact_share, 1);
    if (!p->picture.viewpoint && p->picture.film.projection == RSV_PROJECTION_CAMERA)
        p->solve.goal_camera = p->picture.camera;
}

/// Two passes, which show the noise.
static rsv_status take_first(rsv_planner *p)
{
    uint32_t samples = p->wanted > GENEROUS ? 1 : 2;
    rsv_sample_sum_clear(p->context, &p->sum);
    rsv_progress_part(p->context, "trial", 0);
    rsv_status status = rsv_planner_take(p, samples);
    if (status == RSV_OK) status = rsv_planner_take(p, samples);
    rsv_progress_part(p->context, NULL, 0);
    if (status == RSV_OK) status = rsv_sample_sum_filter(p->context, &p->sum, fall_of(p));
    if (status == RSV_OK) p->plan.noise = rsv_sample_sum_noise(&p->sum, fall_of(p));
    return status;
}

/// What one look at the elements finds.
typedef struct elements_look {
    double error, uncertainty; ///< relative MSE due to elements, and its standard error
    double looked_up_noise;    ///< relative MSE of the first passes by noise, at these pixels
    double gathered_noise;     ///< the same with one gather ray per camera ray
    double kept; ///< relative MSE that gather rays leave because they do not bring all light
} elements_look;

/// Repeats the last two passes at some pixels with gather rays. All other random numbers are the same, so that edges,
/// highlights and shadows add no noise to the differences.
/// @param count [height * width] samples of pixels, in both
static rsv_status take_spots(
    rsv_planner *p, const uint32_t *count, uint32_t rays, rsv_gathered kind, rsv_image *gathered[2])
{
    uint32_t passes = p->passes;
    rsv_gathered before = p->gathered;
    rsv_status status = RSV_OK;
    p->passes -= 2;
    p->gathered = kind;
    p->compares = true;
    p->picture.gather_rays = rays;
    for (int k = 0; k < 2 && status == RSV_OK; k++)
        status = take(p, p->sum.half_samples, count, &gathered[k]);
    p->picture.gather_rays = 0;
    p->gathered = before;
    p->compares = false;
    p->passes = passes;
    return status;
}

/// Relative MSE by noise of the mean of two halves, at some pixels.
static double noise_of(const rsv_planner *p, const rsv_image *const half[2], const uint32_t *count)
{
    const rsv_image *const light[2] = { p->sum.half[0], p->sum.half[1] };
    const rsv_image *const first[2] = { half[0], half[0] }, *const second[2] = { half[1], half[1] };
    const rsv_pixel_error_desc desc = { RSV_MOST_OF_A_PIXEL, light, count };
    double unused;
    return 0.25 * rsv_pixel_error(first, second, desc, &unused);
}

/// Compares both halves with the same gathered. The difference, apart from noise, is the elements' error.
static elements_look compare_spots(
    const rsv_planner *p, const uint32_t *count, rsv_image *const gathered[2])
{
    const rsv_image *const stored[2] = { p->sum.half[0], p->sum.half[1] };
    const rsv_image *const truth[2] = { gathered[0], gathered[1] };
    const rsv_pixel_error_desc desc = { INFINITY, stored, count };
    elements_look look = { 0 };
    look.error = rsv_pixel_error(stored, truth, desc, &look.uncertainty);
    look.looked_up_noise = noise_of(p, stored, count);
    return look;
}

/// How noisy gather rays are, and what they leave, if pixels gather as the planner would have them.
static rsv_status compare_gathering(rsv_planner *p, const uint32_t *count, uint32_t rays,
    rsv_image *const all[2], elements_look *look)
{
    rsv_image *gathered[2] = { NULL, NULL };
    rsv_status status = RSV_OK;
    bool is_all = p->gathered == RSV_GATHERED_ALL;
    if (!is_all) status = take_spots(p, count, rays, p->gathered, gathered);
    if (status == RSV_OK) {
        const rsv_image *const truth[2] = { all[0], all[1] };
        const rsv_image *const some[2] = { is_all ? all[0] : gathered[0],
            is_all ? all[1] : gathered[1] };
        const rsv_image *const stored[2] = { p->sum.half[0], p->sum.half[1] };
        const rsv_pixel_error_desc desc = { INFINITY, stored, count };
        double uncertainty = 0;
        double noise = fmax(noise_of(p, some, count) - look->looked_up_noise, 0);
        look->gathered_noise = look->looked_up_noise + rays * noise;
        look->kept = is_all ? 0 : rsv_pixel_error(some, truth, desc, &uncertainty);
        look->kept = fmax(look->kept - uncertainty, 0);
    }
    rsv_image_destroy(gathered[0]);
    rsv_image_destroy(gathered[1]);
    return status;
}

/// @param count [height * width] samples of pixels to look at @param rays per camera ray
static rsv_status look_at_pixels(
    rsv_planner *p, const uint32_t *count, uint32_t rays, elements_look *look)
{
    rsv_image *gathered[2] = { NULL, NULL };
    rsv_status status = take_spots(p, count, rays, RSV_GATHERED_ALL, gathered);
    if (status == RSV_OK) *look = compare_spots(p, count, gathered);
    if (status == RSV_OK) status = compare_gathering(p, count, rays, gathered, look);
    rsv_image_destroy(gathered[0]);
    rsv_image_destroy(gathered[1]);
    return status;
}

/// @param rays per camera ray @param number of the look
static rsv_status look_at_elements(
    rsv_planner *p, uint32_t rays, uint32_t number, elements_look *look)
{
    uint32_t width = p->picture.width, height = p->picture.height;
    uint32_t *count = rsv_alloc(p->context, (size_t)width * height, sizeof *count);
    if (!count) return RSV_ERROR_MEMORY;
    rsv_choose_spots(
        width, height, SPOTS, rsv_hash2(p->picture.seed, number), 2 * p->sum.half_samples, count);
    rsv_status status = look_at_pixels(p, count, rays, look);
    rsv_free(p->context, count);
    return status;
}

/// Relative MSE by elements: as was found, as far as that is certain, otherwise as is usual. Where some pixels gather,
/// all others were looked at.
static double known_elements_error(const rsv_planner *p)
{
    double found = p->plan.elements_error, usual = USUAL_ELEMENTS_SHARE * p->wanted;
    if (p->selected) return found;
    double spread = ELEMENTS_SHARE_SPREAD * p->wanted;
    double certain = spread * spread / (spread * spread + p->uncertainty * p->uncertainty);
    double least = p->picture.denoise ? FILTERED_ELEMENTS_SHARE * p->wanted : 0;
    return fmax(usual + certain * (found - usual), least);
}

/// Relative MSE that is left for the noise of samples by an error due to elements.
static double noise_beside(const rsv_planner *p, double elements)
{
    double least = p->picture.denoise ? LEAST_FILTERED_NOISE_SHARE : LEAST_NOISE_SHARE;
    return fmax(p->wanted - elements, least * p->wanted);
}

static double noise_allowed(const rsv_planner *p)
{
    return noise_beside(p, known_elements_error(p));
}

static uint32_t samples_needed(const rsv_planner *p)
{
    return rsv_samples_for(
        p->plan.noise / noise_allowed(p), p->sum.samples, fall_of(p), MOST_SAMPLES);
}

/// Gather rays per camera ray that one look may take.
static uint32_t most_rays(const rsv_planner *p)
{
    double pixels = (double)p->picture.width * p->picture.height, spots = fmin(SPOTS, pixels);
    double cost =
        (double)rsv_light_report(p->light)->row_rays + samples_needed(p) * pixels * SAMPLE_COST;
    double rays = LOOK_SHARE * cost / (2 * spots * p->sum.half_samples * GATHER_RAY_COST);
    return (uint32_t)fmin(fmax(rays, FIRST_RAYS), MOST_RAYS);
}

/// Estimates the error of elements, more accurately if that does not decide whether they are good enough.
static rsv_status judge_elements(rsv_planner *p)
{
    elements_look look, further;
    rsv_status status = look_at_elements(p, FIRST_RAYS, 0, &look);
    if (status != RSV_OK) return status;
    double doubt = BEYOND_GATHERING * look.uncertainty / (DOUBTFUL_SHARE * p->wanted);
    uint32_t rays = (uint32_t)fmin(ceil(FIRST_RAYS * doubt), most_rays(p));
    if (rays > FIRST_RAYS && !p->picture.denoise) {
        status = look_at_elements(p, rays, 1, &further);
        if (status != RSV_OK) return status;
        double share = (double)rays / (rays + FIRST_RAYS);
        look.error += share * (further.error - look.error);
        look.uncertainty = hypot((1 - share) * look.uncertainty, share * further.uncertainty);
        look.gathered_noise = further.gathered_noise;
        look.looked_up_noise = further.looked_up_noise;
        look.kept = further.kept;
    }
    p->plan.elements_error = BEYOND_GATHERING * fmax(look.error, 0);
    p->uncertainty = BEYOND_GATHERING * look.uncertainty;
    p->gathered_left = GATHERED_LEFT * p->plan.elements_error + BEYOND_GATHERING * look.kept;
    p->gathered_noise = look.gathered_noise;
    p->looked_up_noise = look.looked_up_noise;
    return RSV_OK;
}

/// Relative MSE by elements: what is known, or more if they err by more than chance.
static double likely_elements_error(const rsv_planner *p)
{
    return fmax(known_elements_error(p), p->plan.elements_error - p->uncertainty);
}

static bool elements_limit(const rsv_planner *p)
{
    return likely_elements_error(p) > ELEMENTS_SHARE * p->wanted;
}

/// What can be done about elements that err much, at more pixels than can be gathered apart.
typedef enum remedy {
    ACCEPT, ///< leave less of the error to noise
    GATHER,
    REFINE
} remedy;

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
    double allowed = noise_beside(p, elements);
    double excess = fmax((elements + allowed) / p->wanted, 1);
    if (excess > TOLERANCE) return INFINITY;
    return pow(excess, EXCESS_POWER) * cost_of_samples(p, p->plan.noise, allowed, false);
}

/// Cost of a finer solution in rays of rows.
static double cost_of_rows(const rsv_planner *p)
{
    const rsv_solve_report *report = rsv_light_report(p->light);
    refinement next = next_refinement(p);
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
    double allowed = noise_beside(p, left);
    return cost_of_samples(p, noise_of_gathering(p), allowed, true);
}

/// The remedy that costs least. @param is_last whether no finer solution may follow
static remedy choose_remedy(const rsv_planner *p, bool is_last)
{
    double accepted = cost_of_accepting(p, likely_elements_error(p));
    double gathered = cost_of_gathering(p, is_last);
    double refined = cost_of_rows(p) + cost_of_samples(p, p->plan.noise, p->wanted, false);
    if (is_last) refined = INFINITY;
    if (gathered < fmin(accepted, refined)) return GATHER;
    return is_last || accepted <= refined ? ACCEPT : REFINE;
}

/// The picture begins again, with gather rays.
static rsv_status begin_gathering(rsv_planner *p)
{
    forget_selection(p);
    p->picture.gather_rays = 1;
    p->plan.gathers = true;
    p->uncertainty *= p->gathered_left / p->plan.elements_error;
    p->plan.elements_error = p->gathered_left;
    return take_first(p);
}

/// Gather rays of each camera ray where pixels are selected.
static uint32_t selecting_rays(const rsv_planner *p)
{
    double pixels = (double)p->picture.width * p->picture.height;
    double rays = SELECTING_RAYS / (2 * pixels * p->sum.half_samples);
    return (uint32_t)fmin(fmax(rays, 1), MOST_SELECTING_RAYS);
}

/// Chooses pixels to gather at.
static rsv_status select_pixels(rsv_planner *p)
{
    uint32_t rays = selecting_rays(p);
    rsv_image *gathered[2] = { NULL, NULL };
    rsv_status status = take_spots(p, NULL, rays, RSV_GATHERED_ALL, gathered);
    if (status == RSV_OK) {
        p->selected = rsv_alloc(p->context, (size_t)p->picture.width * p->picture.height, 1);
        status = p->selected ? RSV_OK : RSV_ERROR_MEMORY;
    }
    if (status == RSV_OK) {
        const rsv_image *const stored[2] = { p->sum.half[0], p->sum.half[1] };
        const rsv_image *const truth[2] = { gathered[0], gathered[1] };
        const rsv_selection_desc desc = { SELECTED_ABOVE * p->wanted,
            (double)rays * 2 * p->sum.half_samples };
        p->plan.gathered_share = rsv_select_pixels(stored, truth, &desc, p->selected);
    }
    rsv_image_destroy(gathered[0]);
    rsv_image_destroy(gathered[1]);
    return status;
}

/// Estimates the error of elements again: what is left of it where light is gathered, and all of it elsewhere.
static rsv_status judge_the_rest(rsv_planner *p)
{
    size_t pixels = (size_t)p->picture.width * p->picture.height;
    uint32_t *count = rsv_alloc(p->context, pixels, sizeof *count);
    elements_look look;
    if (!count) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < pixels; k++)
        count[k] = p->selected[k] ? 0 : 2 * p->sum.half_samples;
    rsv_status status = look_at_pixels(p, count, selecting_rays(p), &look);
    rsv_free(p->context, count);
    if (status != RSV_OK) return status;
    double share = 1 - p->plan.gathered_share;
    double rest = BEYOND_GATHERING * share * fmax(look.error, 0);
    p->plan.elements_error = rest + GATHERED_LEFT * fmax(p->plan.elements_error - rest, 0);
    p->uncertainty = BEYOND_GATHERING * share * look.uncertainty;
    return RSV_OK;
}

/// Gathers at some pixels, where that is all that is needed. The picture begins again.
static rsv_status gather_where_needed(rsv_planner *p)
{
    rsv_status status = select_pixels(p);
    if (status != RSV_OK) return status;
    if (p->plan.gathered_share == 0 || p->plan.gathered_share > MOST_SELECTED) {
        forget_selection(p);
        return RSV_OK;
    }
    status = take_first(p);
    if (status == RSV_OK) status = judge_the_rest(p);
    return status;
}

/// Refines elements while they limit the picture, it helps, and nothing else takes less time.
static rsv_status find_solution(rsv_planner *p)
{
    rsv_status status = p->light ? RSV_OK : rsv_planner_solve(p);
    double before = INFINITY;
    while (status == RSV_OK) {
        p->plan.elements_error = NAN;
        status = take_first(p);
        if (status == RSV_OK) status = judge_elements(p);
        if (status != RSV_OK || !elements_limit(p)) break;
        if (!p->picture.denoise) status = gather_where_needed(p);
        if (status != RSV_OK || !elements_limit(p)) break;
        bool was_stuck = p->is_stuck;
        p->is_stuck = p->plan.elements_error > LEAST_PROGRESS * before;
        bool is_last = p->is_given || p->plan.rounds >= MOST_ROUNDS || (was_stuck && p->is_stuck);
        remedy next = choose_remedy(p, is_last);
        if (next == GATHER) status = begin_gathering(p);
        if (next != REFINE) break;
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
    double elements = known_elements_error(p);
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
        double allowed = noise_allowed(p) * (pass == 0 ? 1 : RETAKE);
        status = rsv_allocate_samples(p->context, &p->sum, fall_of(p), allowed, left, &allocation);
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
    double error = known_elements_error(p) + p->plan.noise;
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
