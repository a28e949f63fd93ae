/// Steps of a plan: solutions, and passes over the picture.
#include "planner.h"

#include "../core/sampling.h"
#include "plan_constants.h"

#include <math.h>

void rsv_planner_forget_selection(rsv_planner *p)
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
    rsv_planner_forget_selection(p);
    rsv_light_destroy(p->light);
    p->light = light;
    p->plan.element_target = p->solve.element_target;
    p->plan.rays_per_element = rsv_light_report(light)->rays_per_row;
    p->plan.refinements = p->solve.refinements;
    p->plan.goal = p->solve.goal_camera != RSV_NONE;
    p->plan.rounds++;
    return RSV_OK;
}

double rsv_planner_fall(const rsv_planner *p)
{
    return p->plan.gathers || p->selected ? RSV_GATHERED_FALL : RSV_STRATIFIED_FALL;
}

rsv_status rsv_planner_take_half(
    rsv_planner *p, uint32_t samples, const uint32_t *count, rsv_image **image)
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
    rsv_status status = rsv_planner_take_half(p, samples, NULL, &pass);
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
        status = rsv_planner_take_half(p, mean, allocation->extra, &pass[half]);
    if (status == RSV_OK) {
        const rsv_uneven_pair pair = { allocation->extra, allocation->renewed, allocation->fall };
        status = rsv_sample_sum_add_uneven(p->context, &p->sum, &pair, pass);
        if (status == RSV_OK) status = rsv_sample_sum_filter(p->context, &p->sum, allocation->fall);
    } else {
        rsv_image_destroy(pass[0]);
    }
    if (status == RSV_OK) p->plan.noise = rsv_uneven_noise(&p->sum);
    return status;
}

rsv_status rsv_planner_take_first(rsv_planner *p)
{
    uint32_t samples = p->wanted > GENEROUS ? 1 : 2;
    rsv_sample_sum_clear(p->context, &p->sum);
    rsv_progress_part(p->context, "trial", 0);
    rsv_status status = rsv_planner_take(p, samples);
    if (status == RSV_OK) status = rsv_planner_take(p, samples);
    rsv_progress_part(p->context, NULL, 0);
    if (status == RSV_OK) status = rsv_sample_sum_filter(p->context, &p->sum, rsv_planner_fall(p));
    if (status == RSV_OK) p->plan.noise = rsv_sample_sum_noise(&p->sum, rsv_planner_fall(p));
    return status;
}
