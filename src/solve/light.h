/// The light of a scene: E = E0 + G K E, solved on the elements of an operator, with E0 also on finer levels.
///
/// Other rooms read a light through its view, and change it through the functions here. One operator can have any
/// number of lights.
#ifndef RSV_LIGHT_H
#define RSV_LIGHT_H

#include "../direct/source_level.h"
#include "diffused_level.h"
#include "light_basis.h"
#include "light_sources.h"
#include "operator.h"
#include "resolvent/solve.h"

/// Fields of a light, on the elements of its operator and on its own levels.
typedef struct rsv_light_fields {
    rsv_rgb *gathered;               ///< [node_count] the part of E0 that gather rays found
    rsv_rgb *source;                 ///< [node_count] E0, all of it, on the coarse elements
    rsv_rgb *irradiance;             ///< [node_count] E = E0 + G K E, as solved
    rsv_rgb *order[RSV_KEPT_ORDERS]; ///< [node_count] (G K)^n E0, sharpened from n = 1 on
    uint32_t order_count;
    rsv_rgb *indirect;           ///< [node_count] sum of the orders from 1 on
    rsv_source_level fine;       ///< direct; elements NULL = direct light is the coarse `source`
    rsv_source_level caustics;   ///< elements NULL = there are none
    rsv_diffused_level diffused; ///< light of translucent surfaces; elements NULL = there are none
} rsv_light_fields;

/// A light for lookups. It does not move while the light exists, and follows its changes.
typedef struct rsv_light_view {
    const rsv_light *light; ///< whose view this is
    rsv_context *context;
    const rsv_operator *op;
    rsv_transport_scene scene; ///< of this light
    const rsv_tracer *tracer;  ///< of that
    const rsv_bsdf *bsdf;      ///< of this light
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
    rsv_diffused_level diffused; ///< light of translucent surfaces; elements NULL = there are none
    rsv_rgb gathered_scale; ///< factor of the emission that rows gathered when they were traced
    double pocket_area; ///< m2 of elements left dark, as they absorb nothing and hardly see light

    const rsv_light_basis *basis; ///< parts of E0; NULL = not found yet
    rsv_solve_report report;
} rsv_light_view;

const rsv_light_view *rsv_light_get_view(const rsv_light *light);

void rsv_light_fields_free(rsv_context *context, rsv_light_fields *fields);

/// Restores a light from stored data.
/// @param op, sources retained
/// @param desc of the original solve; goal_points are copied
/// @param fields owned by the light, even on failure
rsv_status rsv_light_restore(rsv_operator *op, rsv_light_sources *sources,
    const rsv_solve_desc *desc, const rsv_light_fields *fields, const rsv_solve_report *report,
    rsv_light **light);

/// RSV_ERROR_UNSUPPORTED if the light's scene has fog. @param what cannot be done: "a frame"
rsv_status rsv_light_refuse_fog(const rsv_light_view *light, const char *what);

/// Whether each source's part of E0 is known. With anisotropic fog, the light of all sources is in the rows; and
/// emission of fog has no source.
bool rsv_light_has_parts(const rsv_light_view *light);
/// RSV_ERROR_UNSUPPORTED where it cannot.
rsv_status rsv_light_require_parts(const rsv_light_view *light);

/// Direct irradiance, from the fine level if there is one.
/// @param skip_sampled without the light that next-event estimation finds, which the caller samples
rsv_rgb rsv_light_view_direct(
    const rsv_light_view *light, uint32_t face, float u, float v, bool skip_sampled);

/// Whether there are caustics that no gather ray can find. Gather rays then leave all light of photons to the stored
/// caustics.
bool rsv_has_unseen_caustics(const rsv_light_view *light);

/// Stored light of a voxel (elements/voxels.h): of order 0 (all of E0, or its gathered part), of one further order, or
/// of all from 1 on (RSV_NONE); times the fog's albedo / pi: isotropically scattered radiance.
/// @param skip_sampled without the part of order 0 that next-event estimation finds, which the caller samples
rsv_rgb rsv_light_view_scattered(
    const rsv_light_view *light, uint32_t node, uint32_t order, bool skip_sampled);

/// Solved irradiance at a point of a triangle, as rsv_light_irradiance.
rsv_rgb rsv_light_view_irradiance(const rsv_light_view *light, uint32_t triangle, float u, float v,
    bool back_side, uint32_t order);

/// Of the random numbers of the direct and caustic levels.
static inline uint32_t rsv_level_seed(uint32_t seed) { return seed ^ 0x2545f491u; }

/// Coarse elements are few, and each one affects all others: their direct light gets this many times the shadow rays.
#define RSV_COARSE_LIGHT_FACTOR 2

#endif
