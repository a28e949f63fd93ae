/// @file plan.h
/// Pictures with a given error or in a given time: elements, rays and camera samples are chosen together.
#ifndef RESOLVENT_PLAN_H
#define RESOLVENT_PLAN_H

#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Options of a planned picture. Start from rsv_default_plan_desc().
typedef struct rsv_plan_desc {
    size_t size; ///< sizeof this structure; rsv_default_plan_desc() sets it
    /// Target RMS error of pixels, relative to the pixels around them (its square is rsv_image_judgement.relative_mse);
    /// 0.005..1, default 0.07. 0 = as good as time permits.
    double relative_error;
    /// Limit of wall time in seconds, from the start of the call. The picture is as good as time permits, and then
    /// depends on the machine. INFINITY (default) = no limit; the result is then the same on every machine.
    double max_seconds;
    /// Solver, seed and budgets; the plan chooses everything else. Borrowed; NULL (default) = those of draft quality.
    const rsv_solve_desc *solve;
} rsv_plan_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_plan_desc().
RSV_API void rsv_plan_desc_init(rsv_plan_desc *desc, size_t size);
static inline rsv_plan_desc rsv_default_plan_desc(void)
{
    rsv_plan_desc desc;
    rsv_plan_desc_init(&desc, sizeof desc);
    return desc;
}

/// The choices of a plan, and its result.
typedef struct rsv_picture_plan {
    rsv_render_mode mode; ///< RSV_RENDER_REFERENCE if there was no time for a solution, or no light
    uint32_t element_target, rays_per_element, refinements; ///< of the last solution
    bool goal;        ///< the solution was refined for the camera's picture
    bool gathers;     ///< indirect light is gathered with one ray per camera ray, not looked up
    uint32_t rounds;  ///< number of solutions
    uint32_t samples; ///< mean number of camera rays per pixel
    double noise;     ///< estimated relative MSE due to camera samples
    double
        elements_error; ///< estimated relative MSE due to elements and their rays; NAN = not estimated
    bool is_reached;    ///< whether the estimates meet the target
    double
        gathered_share; ///< fraction of pixels that gather indirect light, with some rays per camera ray
} rsv_picture_plan;

/// Renders a planned picture in mode final. Solves with few elements, takes a few samples to measure noise, determines
/// whether the solution or the samples limit the error, and refines that part.
/// @param picture size, camera, layers, seed and denoise; the plan chooses the samples. The error of a picture that is
/// denoised is that after the filter, and less certain: up to 1.6 times the target in furnished rooms
/// @param light in: a solution to use unchanged, or NULL; out: the solution used, NULL in mode reference
/// @param plan out; may be NULL
RSV_API rsv_status rsv_render_planned(const rsv_scene *scene, const rsv_plan_desc *desc,
    const rsv_render_desc *picture, rsv_light **light, rsv_image **image, rsv_picture_plan *plan);

#ifdef __cplusplus
}
#endif

#endif
