/// The light-transport operator of a scene, G K: the fraction of the light arriving at each element that arrives at
/// each other one next. Constant once it is created, while its lights come and go (light.h).
///
/// The rows, G, are the expensive part: operators with other albedos (K) share them with the operator that they vary.
#ifndef RSV_OPERATOR_H
#define RSV_OPERATOR_H

#include "../diffusion/subsurface.h"
#include "../operator/transport.h"
#include "resolvent/operator.h"
#include "transport_map.h"
#include "world.h"

/// Parts of an operator. All are constant, except for scratch memory in `subsurface`.
typedef struct rsv_operator_view {
    rsv_context *context;
    rsv_world *world;             ///< with its surfaces
    rsv_elements *elements;       ///< where light is stored: the unknowns
    const uint16_t *valid_points; ///< [node_count] receiver points that are not buried, bit by bit
    rsv_transport *transport;     ///< G
    const rsv_rgb *albedo;        ///< [node_count] K = diag(albedo) P
    rsv_subsurface *subsurface;   ///< P; NULL = light leaves where it entered, everywhere
} rsv_operator_view;

/// How to trace one.
typedef struct rsv_operator_desc {
    rsv_world *world;        ///< retained
    rsv_elements *elements;  ///< retained
    rsv_transport_desc rows; ///< of that world and those elements; borrowed for the call
} rsv_operator_desc;

rsv_status rsv_operator_trace(const rsv_operator_desc *desc, rsv_operator **op);

/// Restores an operator. @param parts world and elements are retained, everything else is owned, even on failure
rsv_status rsv_operator_restore(const rsv_operator_view *parts, rsv_operator **op);

/// The same rows with other albedos. @param world whose they are; retained @param albedo [node_count], copied
rsv_status rsv_operator_recolor(
    rsv_operator *base, rsv_world *world, const rsv_rgb *albedo, rsv_operator **op);

/// Adds P, where anything is translucent. Part of making an operator, once.
rsv_status rsv_operator_scatter(rsv_operator *op);

const rsv_operator_view *rsv_operator_get_view(const rsv_operator *op);

/// Whether all channels of light spread alike, so that three gray fields can share one. Said only where all rows are
/// here, and light leaves surfaces where it entered.
bool rsv_operator_is_gray(const rsv_operator *op);

/// Albedo of a node, textured ones as means over their hat functions.
rsv_rgb rsv_element_albedo(
    const rsv_transport_scene *scene, const rsv_elements *elements, uint32_t seed, uint32_t node);

/// Albedos of all nodes. @param albedo out: [node_count], freed by the caller
rsv_status rsv_element_albedos(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t seed, rsv_rgb **albedo);

/// Whether any material reflects diffusely. If none does, irradiance has no effect: cameras and probes see only light
/// straight from the sources.
bool rsv_reflects_diffusely(const rsv_transport_scene *scene);

/// G K as a linear map for solvers; borrows the operator. @param fields RGB fields at once, at most
rsv_status rsv_operator_map(const rsv_operator *op, size_t fields, rsv_transport_map **map);

/// Nodes with a row of their own.
size_t rsv_count_rows(const rsv_elements *elements, const uint16_t *valid_points);

#endif
