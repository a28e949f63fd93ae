/// The contents of a light, for the files that compute it.
#ifndef RSV_LIGHT_INTERNAL_H
#define RSV_LIGHT_INTERNAL_H

#include "light_change.h"
#include "resolvent/update.h"

struct rsv_following; // light_follow.c

struct rsv_light {
    rsv_context *context;
    rsv_operator *op;             ///< of its world's colours
    const rsv_elements *elements; ///< of that: coarse, the unknowns
    rsv_world *world;             ///< the scene of this light
    rsv_transport_scene scene;  ///< of the world; during the build with results from before an edit
    rsv_light_sources *sources; ///< of that world
    rsv_solve_desc desc;        ///< goal_points are those below
    rsv_probe *goal_points;     ///< a copy; NULL = none

    rsv_light_fields field;
    rsv_rgb gathered_scale; ///< factor of the emission that rows gathered when they were traced
    double pocket_area;
    rsv_light_basis *basis;
    rsv_solve_report report;
    struct rsv_following *following; ///< data for moving surfaces; NULL = nothing has moved yet
    rsv_update_report update;        ///< reuse after an edit, as far as it is not in `report`

    rsv_light_view view; ///< all of that, for others
};

/// A light without E0: sources, and memory for E0 on the coarse elements.
/// @param op, sources retained
/// @param scene of the operator's world, with results from before an edit; copied
rsv_status rsv_light_begin(rsv_operator *op, rsv_light_sources *sources,
    const rsv_transport_scene *scene, const rsv_solve_desc *desc, rsv_light **light);

/// @param following NULL is allowed
void rsv_following_destroy(rsv_context *context, struct rsv_following *following);

/// Frees the photons kept between motions: the sources are about to be others. @param following NULL is allowed
void rsv_following_forget_photons(struct rsv_following *following);

/// RSV_ERROR_SCENE where the light never dies out in the operator that it has now.
rsv_status rsv_light_check_bounded(rsv_light *light);

/// Gives a light a variant of the world that it has.
rsv_status rsv_light_part_world(rsv_light *light);

/// Logs warnings about the solution.
void rsv_light_warn_if_unbounded(const rsv_light *light);

/// Frees the orders that are kept apart; there are none then.
void rsv_light_drop_orders(rsv_light *light);

/// Solves E = E0 + G K E: keeps the first orders of light separately, and leaves the rest to the solver in the
/// description, or the one that suits the norm. Fills the report.
/// @param max_orders maximum number of applications of G K
rsv_status rsv_solve_orders(rsv_light *light, uint32_t max_orders);

/// Solves E = E0 + G K E again after E0 and G changed a little, from the E that there is. Orders are not kept apart any
/// more; the spectral radius stays that of before.
/// @param max_orders maximum number of applications of G K
rsv_status rsv_solve_on(rsv_light *light, uint32_t max_orders);

/// The same with as many applications as the description allows, and then the spectral radius, converged.
rsv_status rsv_solve_and_measure(rsv_light *light);

#endif
