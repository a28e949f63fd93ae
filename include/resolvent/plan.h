/// @file plan.h
/// A picture with a given error or time: elements, rays and camera samples are chosen together.
#ifndef RESOLVENT_PLAN_H
#define RESOLVENT_PLAN_H

#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Start from rsv_default_plan_desc().
typedef struct rsv_plan_desc {
    size_t size; ///< of this structure; rsv_default_plan_desc() sets it
    /// Wanted RMS error of pixels, relative to what is around them (rsv_image_judgement.relative_mse is its square): 0.005 to 1,
    /// default 0.07. 0 = as good as there is time for.
    double relative_error;
    /// Seconds from the call on, by the clock: the picture is as good as fits into them, and depends on the machine then.
    /// INFINITY (default) = no limit: all follows from counts and is the same on every machine.
    double max_seconds;
    /// Solver, seed and budgets; the plan chooses what else it says. Borrowed; NULL (default) = those of draft quality.
    const rsv_solve_desc *solve;
} rsv_plan_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_plan_desc() is made of.
RSV_API void rsv_plan_desc_init(rsv_plan_desc *desc, size_t size);
static inline rsv_plan_desc rsv_default_plan_desc(void)
{
    rsv_plan_desc desc;
    rsv_plan_desc_init(&desc, sizeof desc);
    return desc;
}

/// What was chosen, and what came of it.
typedef struct rsv_picture_plan {
    rsv_render_mode mode; ///< RSV_RENDER_REFERENCE where there was no time for a solution
    uint32_t element_target, rays_per_element, refinements; ///< of the last solution
    bool goal;        ///< elements were spent on what the camera sees
    bool gathers;     ///< indirect light is found by a gather ray per camera ray, not looked up
    uint32_t rounds;  ///< solutions that were made
    uint32_t samples; ///< camera rays per pixel, on average
    double noise;     ///< estimated relative MSE by camera samples
    double elements_error; ///< likewise by elements and their rays; NAN = it was not looked at
    bool is_reached;       ///< whether the estimates keep to the wanted error
} rsv_picture_plan;

/// Renders mode final by a plan: solves on few elements, takes a few samples to learn their noise, looks whether the
/// solution or the samples limit the error, and refines that.
/// @param picture size, camera, layers and seed; the plan chooses the samples
/// @param light in: a solution to be used as it is, or NULL; out: the one used, NULL for mode reference
/// @param plan may be NULL
RSV_API rsv_status rsv_render_planned(const rsv_scene *scene, const rsv_plan_desc *desc,
    const rsv_render_desc *picture, rsv_light **light, rsv_image **image, rsv_picture_plan *plan);

#ifdef __cplusplus
}
#endif

#endif
