#include "elements_error.h"

#include "../core/sampling.h"
#include "pixel_error.h"
#include "plan_constants.h"
#include "selection.h"
#include "spots.h"

#include <math.h>

// ---- what is known ---------------------------------------------------------------------------------

double rsv_known_elements_error(const rsv_planner *p)
{
    double found = p->plan.elements_error, usual = USUAL_ELEMENTS_SHARE * p->wanted;
    if (p->selected) return found;
    double spread = ELEMENTS_SHARE_SPREAD * p->wanted;
    double certain = spread * spread / (spread * spread + p->uncertainty * p->uncertainty);
    double least = p->picture.denoise ? FILTERED_ELEMENTS_SHARE * p->wanted : 0;
    return fmax(usual + certain * (found - usual), least);
}

double rsv_noise_beside(const rsv_planner *p, double elements)
{
    double least = p->picture.denoise ? LEAST_FILTERED_NOISE_SHARE : LEAST_NOISE_SHARE;
    return fmax(p->wanted - elements, least * p->wanted);
}

double rsv_noise_allowed(const rsv_planner *p)
{
    return rsv_noise_beside(p, rsv_known_elements_error(p));
}

static uint32_t samples_needed(const rsv_planner *p)
{
    return rsv_samples_for(
        p->plan.noise / rsv_noise_allowed(p), p->sum.samples, rsv_planner_fall(p), MOST_SAMPLES);
}

double rsv_likely_elements_error(const rsv_planner *p)
{
    return fmax(rsv_known_elements_error(p), p->plan.elements_error - p->uncertainty);
}

bool rsv_elements_limit(const rsv_planner *p)
{
    return rsv_likely_elements_error(p) > ELEMENTS_SHARE * p->wanted;
}

// ---- looks -----------------------------------------------------------------------------------------

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
        status = rsv_planner_take_half(p, p->sum.half_samples, count, &gathered[k]);
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
    return RSV_ERROR_OF_HALVES * rsv_pixel_error(first, second, desc, &unused);
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

/// Gather rays per camera ray that one look may take.
static uint32_t most_rays(const rsv_planner *p)
{
    double pixels = (double)p->picture.width * p->picture.height, spots = fmin(SPOTS, pixels);
    double cost =
        (double)rsv_light_report(p->light)->row_rays + samples_needed(p) * pixels * SAMPLE_COST;
    double rays = LOOK_SHARE * cost / (2 * spots * p->sum.half_samples * GATHER_RAY_COST);
    return (uint32_t)fmin(fmax(rays, FIRST_RAYS), MOST_RAYS);
}

rsv_status rsv_judge_elements(rsv_planner *p)
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

// ---- selected pixels -------------------------------------------------------------------------------

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

rsv_status rsv_gather_where_needed(rsv_planner *p)
{
    rsv_status status = select_pixels(p);
    if (status != RSV_OK) return status;
    if (p->plan.gathered_share == 0 || p->plan.gathered_share > MOST_SELECTED) {
        rsv_planner_forget_selection(p);
        return RSV_OK;
    }
    status = rsv_planner_take_first(p);
    if (status == RSV_OK) status = judge_the_rest(p);
    return status;
}
