/// The light of a scene: E = E0 + G K E, solved on the elements of an operator, with E0 on finer levels beside.
///
/// Other rooms read a light through its view and change it through the functions here. As many lights of one operator as
/// are wanted live side by side.
#ifndef RSV_LIGHT_H
#define RSV_LIGHT_H

#include "../direct/source_level.h"
#include "diffused_level.h"
#include "light_basis.h"
#include "light_sources.h"
#include "operator.h"
#include "resolvent/solve.h"

/// What a light consists of on the elements of its operator and on levels of its own.
typedef struct rsv_light_fields {
    rsv_rgb *gathered;               ///< [node_count] the part of E0 that gather rays found
    rsv_rgb *source;                 ///< [node_count] E0, all of it, on the coarse elements
    rsv_rgb *irradiance;             ///< [node_count] E = E0 + G K E, as solved
    rsv_rgb *order[RSV_KEPT_ORDERS]; ///< [node_count] (G K)^n E0, sharpened from n = 1 on
    uint32_t order_count;
    rsv_rgb *indirect;           ///< [node_count] sum of the orders from 1 on
    rsv_source_level fine;       ///< direct; elements NULL = direct light is the coarse `source`
    rsv_source_level caustics;   ///< elements NULL = there are none
    rsv_diffused_level diffused; ///< what translucent surfaces show; elements NULL = there are none
} rsv_light_fields;

/// All of a light, to be looked up. Stays where it is while the light lives, and follows its changes.
typedef struct rsv_light_view {
    const rsv_light *light; ///< whose view this is
    rsv_context *context;
    const rsv_operator *op;
    rsv_transport_scene scene; ///< as this light has it
    const rsv_tracer *tracer;  ///< of that
    const rsv_bsdf *bsdf;      ///< likewise
    const rsv_lights *lights;
    const rsv_fog_lights *fog_lights; ///< the same as fog is lit by them; NULL = the air is clear
    rsv_solve_desc desc;

    const rsv_elements *elements; ///< coarse: unknowns
    const uint16_t *valid_points; ///< [node_count] receiver points that are not buried, bit by bit
    const rsv_transport *transport;
    const rsv_rgb *exitance_albedo; ///< [node_count] K = diag(exitance_albedo) P
    const rsv_subsurface *subsurface;

    const rsv_rgb *bin_radiance;           ///< [RSV_ESCAPE_BINS] of the surroundings
    const rsv_rgb *gathered;               ///< [node_count] the part of E0 that gather rays found
    const rsv_rgb *source;                 ///< [node_count] E0, all of it, on the coarse elements
    const rsv_rgb *irradiance;             ///< [node_count] E = E0 + G K E, as solved
    const rsv_rgb *order[RSV_KEPT_ORDERS]; ///< [node_count] (G K)^n E0, sharpened from n = 1 on
    uint32_t order_count;
    const rsv_rgb *indirect;     ///< [node_count] sum of the orders from 1 on
    rsv_source_level fine;       ///< direct; elements NULL = direct light is the coarse `source`
    rsv_source_level caustics;   ///< elements NULL = there are none
    rsv_diffused_level diffused; ///< what translucent surfaces show; elements NULL = there are none
    rsv_rgb gathered_scale; ///< factor of the emission that rows gathered when they were traced
    double pocket_area; ///< m2 of elements left dark, as they absorb nothing and hardly see light

    const rsv_light_basis *basis; ///< parts of E0; NULL = not found yet
    rsv_solve_report report;
} rsv_light_view;

const rsv_light_view *rsv_light_get_view(const rsv_light *light);

void rsv_light_fields_free(rsv_context *context, rsv_light_fields *fields);

/// A light from what was kept of one.
/// @param op, sources retained
/// @param desc what it was made for; goal_points are copied
/// @param fields taken over, even on failure
rsv_status rsv_light_restore(rsv_operator *op, rsv_light_sources *sources,
    const rsv_solve_desc *desc, const rsv_light_fields *fields, const rsv_solve_report *report,
    rsv_light **light);

/// RSV_ERROR_UNSUPPORTED where the light's scene has fog. @param what will not go on: "a frame"
rsv_status rsv_light_refuse_fog(const rsv_light_view *light, const char *what);

/// Whether each source's part of E0 can be told: fog that scatters unevenly turns light of all sources into rows, and fog that
/// emits has no source.
bool rsv_light_has_parts(const rsv_light_view *light);
/// RSV_ERROR_UNSUPPORTED where it cannot.
rsv_status rsv_light_require_parts(const rsv_light_view *light);

/// Direct irradiance from the fine level where there is one.
/// @param skip_sampled leave out what next-event estimation finds: the caller does that itself
rsv_rgb rsv_light_view_direct(
    const rsv_light_view *light, uint32_t face, float u, float v, bool skip_sampled);

/// What is stored at a voxel (elements/voxels.h), as of order 0 (all of E0, or what was gathered of it), of one further order,
/// or of all from 1 on (RSV_NONE); times the fog's albedo, over pi: radiance that is scattered there to all sides alike.
/// @param skip_sampled leave out of order 0 what next-event estimation finds: the caller does that itself
rsv_rgb rsv_light_view_scattered(
    const rsv_light_view *light, uint32_t node, uint32_t order, bool skip_sampled);

/// Solved irradiance at a point of a triangle, as rsv_light_irradiance.
rsv_rgb rsv_light_view_irradiance(const rsv_light_view *light, uint32_t triangle, float u, float v,
    bool back_side, uint32_t order);

/// Of the random numbers of the direct and caustic levels.
static inline uint32_t rsv_level_seed(uint32_t seed) { return seed ^ 0x2545f491u; }

/// Coarse elements are few and each feeds all others: their direct light gets so many times the shadow rays.
#define RSV_COARSE_LIGHT_FACTOR 2

#endif
