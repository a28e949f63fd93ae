/// Light of translucent surfaces: irradiance diffused below them, on elements as fine as the diffusion requires.
///
/// Direct light has edges that elements do not resolve. The profile's transfer function at the finest wave that they
/// resolve is the fraction of such detail that survives diffusion. With it, the difference between a better estimate of
/// direct light and the elements' own is added at each lookup. The fraction is 0 where elements are finer than the mean
/// free path, and 1 where the mean free path is 0 and the surface Lambertian.
#ifndef RSV_DIFFUSED_LEVEL_H
#define RSV_DIFFUSED_LEVEL_H

#include "../direct/source_level.h"

struct rsv_light;
struct rsv_light_view;

/// Orders kept apart; the last one collects all higher ones.
#define RSV_KEPT_ORDERS 8

typedef struct rsv_diffused_level {
    rsv_elements *elements;
    uint8_t *material; ///< [material_count] whether it diffuses light below the surface
    rsv_rgb *entered;  ///< [node_count] direct irradiance
    rsv_rgb *order[RSV_KEPT_ORDERS]; ///< [node_count] P (G K)^n E0
    rsv_rgb *indirect;               ///< [node_count] sum of the orders from 1 on
} rsv_diffused_level;

/// Finds out which materials are translucent. Part of creating the level.
rsv_status rsv_diffused_level_name_materials(struct rsv_light *solution);

/// Builds the level of a solved solution. Leaves it empty if the scene has no translucent material.
rsv_status rsv_diffused_level_create(struct rsv_light *solution);
void rsv_diffused_level_destroy(rsv_context *context, rsv_diffused_level *level);

/// A copy on the same elements, with its own fields. @param copy empty before; destroy it even after an error
rsv_status rsv_diffused_level_copy(rsv_context *context, const rsv_diffused_level *level,
    size_t material_count, rsv_diffused_level *copy);

/// Whether light leaves a face elsewhere than it entered.
bool rsv_is_translucent(const struct rsv_light_view *light, uint32_t face);

/// Diffused irradiance of one order, 0 = direct; RSV_NONE = all but the direct.
rsv_rgb rsv_light_view_diffused(
    const struct rsv_light_view *light, uint32_t face, float u, float v, uint32_t order);

/// Direct light diffused, with the share of the direct level's detail that survives.
rsv_rgb rsv_light_view_diffused_direct(
    const struct rsv_light_view *light, uint32_t face, float u, float v);

/// The share of detail below the size of a cell that survives diffusion: all of it on surfaces that are not
/// translucent.
rsv_rgb rsv_diffused_share(const rsv_elements *elements, uint32_t cell);

/// The direct irradiance of the level at a point, and the fraction of unresolved detail that survives.
typedef struct rsv_unresolved {
    rsv_rgb known, share;
} rsv_unresolved;

rsv_unresolved rsv_light_unresolved(
    const struct rsv_light_view *light, uint32_t face, float u, float v);

#endif
