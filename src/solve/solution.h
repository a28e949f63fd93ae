/// What a solution holds; for the rooms that read it in hot loops.
#ifndef RSV_SOLUTION_H
#define RSV_SOLUTION_H

#include "../diffusion/subsurface.h"
#include "../direct/source_level.h"
#include "../elements/spacing.h"
#include "../operator/transport.h"
#include "diffused_level.h"
#include "light_basis.h"
#include "resolvent/solve.h"

struct rsv_solution {
    rsv_context *context;
    rsv_transport_scene scene;
    rsv_tracer *tracer;
    rsv_bsdf *bsdf;
    rsv_lights *lights;
    rsv_solve_desc desc;    ///< with fewer rays than was asked for where a budget wants that
    rsv_probe *goal_points; ///< a copy: desc.goal_points; NULL = none
    uint32_t wanted_rays;   ///< that were asked for
    float wanted_metres;    ///< of the spacing, likewise
    size_t bytes_left;      ///< of the memory budget, for elements, rows and levels

    rsv_spacing spacing;        ///< of the coarse elements
    rsv_elements *elements;     ///< coarse: unknowns
    rsv_transport *transport;   ///< G
    rsv_rgb *exitance_albedo;   ///< [node_count] K = diag(exitance_albedo) P
    rsv_subsurface *subsurface; ///< P; NULL = light leaves where it entered, everywhere
    uint16_t *valid_points;     ///< [node_count] receiver points that are not buried, bit by bit
    rsv_rgb *bin_radiance;      ///< [RSV_ESCAPE_BINS] of the surroundings
    rsv_rgb *gathered;          ///< [node_count] the part of E0 that gather rays found
    rsv_rgb *source;            ///< [node_count] E0, all of it, on the coarse elements
    rsv_rgb *irradiance;        ///< [node_count] E = E0 + G K E, as solved
    rsv_rgb *order[RSV_KEPT_ORDERS]; ///< [node_count] (G K)^n E0, sharpened from n = 1 on
    uint32_t order_count;
    double pocket_area; ///< m2 of elements left dark, as they absorb nothing and hardly see light
    rsv_rgb *indirect;  ///< [node_count] sum of the orders from 1 on
    rsv_source_level fine;       ///< direct; elements NULL = direct light is the coarse `source`
    rsv_source_level caustics;   ///< elements NULL = there are none
    rsv_diffused_level diffused; ///< what translucent surfaces show; elements NULL = there are none

    rsv_light_basis *basis; ///< parts of E0; NULL = not found yet

    rsv_solve_report report;
};

/// A solution of nothing yet: surfaces, rays and lights of a scene.
/// @param desc checked here
rsv_status rsv_solution_prepare(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_solution **solution);

/// What materials are, as the scene has them now.
void rsv_solution_find_bsdfs(rsv_solution *solution);

/// Finds surfaces and lights again after the scene's strengths and colours changed.
/// @param like lights of the same scene: what they gather is gathered
rsv_status rsv_solution_refresh(rsv_solution *solution, const rsv_lights *like);

/// Takes over how strong sources are, the environment being as it was. @param followed as in rsv_lights_follow_strengths
rsv_status rsv_solution_follow_strengths(rsv_solution *solution, bool *followed);

/// Coarse elements are few and each feeds all others: their direct light gets so many times the shadow rays.
#define RSV_COARSE_LIGHT_FACTOR 2

/// Of the random numbers of the direct and caustic levels.
static inline uint32_t rsv_level_seed(const rsv_solution *solution)
{
    return solution->desc.seed ^ 0x2545f491u;
}

/// Solves again, after sources or albedos changed.
rsv_status rsv_solution_solve_again(rsv_solution *solution);

/// Direct irradiance from the fine level where there is one.
/// @param skip_sampled leave out what next-event estimation finds: the caller does that itself
rsv_rgb rsv_solution_direct(
    const rsv_solution *solution, uint32_t face, float u, float v, bool skip_sampled);

/// Solves E = E0 + G K E: keeps the first orders of light one by one, leaves the rest to the solver that the description
/// asks for or the norm suggests. Fills the report.
/// @param max_orders applications of G K at most
rsv_status rsv_solve_orders(rsv_solution *solution, uint32_t max_orders);

/// The same with as many applications as the description allows, and then the spectral radius, converged.
rsv_status rsv_solve_and_measure(rsv_solution *solution);

#endif
