/// A picture that is being planned.
#ifndef RSV_PLANNER_H
#define RSV_PLANNER_H

#include "../core/core.h"
#include "../render/picture_series.h"
#include "allocation.h"
#include "resolvent/plan.h"

typedef struct rsv_planner {
    const rsv_scene *scene;
    rsv_context *context;
    rsv_render_desc picture;    ///< mode and samples are those of the next pass
    rsv_solve_desc solve;       ///< of the next solution
    rsv_light *light;           ///< NULL = none yet
    bool is_given;              ///< whether it is the caller's
    rsv_picture_series *series; ///< of passes with this light; NULL = none yet
    double started;             ///< as rsv_seconds counts
    double wanted;              ///< relative MSE
    rsv_gathered gathered;      ///< by passes with gather rays
    bool compares;              ///< passes are for comparing, not for the picture
    double uncertainty;         ///< standard error of plan.elements_error
    uint32_t passes;
    rsv_sample_sum sum;
    bool is_stuck; ///< the last solution has not helped
    uint8_t *
        selected; ///< [height * width] pixels that gather (selection.h); NULL = none were chosen for this light
    double
        gathered_noise; ///< relative MSE of the first passes, had they one gather ray per camera ray
    double gathered_left;   ///< relative MSE by elements that would be left
    double looked_up_noise; ///< the same as they are, without filter
    rsv_picture_plan plan;
} rsv_planner;

/// Solves by the planner's description, in place of its solution before.
rsv_status rsv_planner_solve(rsv_planner *planner);

/// Selected pixels are those of one solution.
void rsv_planner_forget_selection(rsv_planner *planner);

/// Power of the samples with which squared errors fall.
double rsv_planner_fall(const rsv_planner *planner);

/// Takes one pass of a pair, which are the halves of one stratified picture.
/// @param samples of this pass, in each pixel or on average
/// @param count [height * width] samples of each pixel in both passes, not of path traced ones; NULL = the same in all
rsv_status rsv_planner_take_half(
    rsv_planner *planner, uint32_t samples, const uint32_t *count, rsv_image **image);

/// Takes the first two passes, which show the noise.
rsv_status rsv_planner_take_first(rsv_planner *planner);

/// Takes one more pass over the picture and adds it.
rsv_status rsv_planner_take(rsv_planner *planner, uint32_t samples);

/// Finds the outlines that get more camera rays, in the picture that there is.
rsv_status rsv_planner_find_outlines(rsv_planner *planner);

/// Takes a pass with a number of camera rays for each pixel and adds it, with the noise that is left.
rsv_status rsv_planner_take_allocated(rsv_planner *planner, const rsv_allocation *allocation);

/// As good a picture as there is time for.
rsv_status rsv_planner_run_until(rsv_planner *planner, double seconds);

#endif
