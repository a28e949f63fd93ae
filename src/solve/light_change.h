/// Changes a light in place: strengths, positions and colours, and everything that follows from them. For rooms that
/// relight.
#ifndef RSV_LIGHT_CHANGE_H
#define RSV_LIGHT_CHANGE_H

#include "light.h"

/// Gives a light a world of its own, whose scene may be changed, where it still has that of its operator.
rsv_status rsv_light_vary_world(rsv_light *light);

/// The world of a light. Its `variant` is there after that.
rsv_world *rsv_light_world(rsv_light *light);

/// Fields for writing. Changes become visible with rsv_light_publish.
rsv_light_fields *rsv_light_edit(rsv_light *light);

/// Brings the view up to date.
void rsv_light_publish(rsv_light *light);

/// Finds sources again after changes of the scene's strengths, positions and colours.
/// @param like lights of the same scene: the same sources are gathered
rsv_status rsv_light_find_sources(rsv_light *light, const rsv_lights *like);

/// Takes over how strong sources are, the environment being as it was. @param followed as in
/// rsv_lights_follow_strengths
rsv_status rsv_light_follow_strengths(rsv_light *light, bool *followed);

/// Lets triangles of some materials be moved in the light's own scene. @param moves [material_count]
rsv_status rsv_light_vary_places(rsv_light *light, const bool *moves);

/// Takes over where sources stand, nothing else having changed.
rsv_status rsv_light_follow_places(rsv_light *light);

/// Sets the factor of gathered emission. Adds that emission, the environment seen by rows, and caustics to the
/// next-event estimates in `source`.
void rsv_light_gather(rsv_light *light, rsv_rgb scale);

/// Sets only that factor, for a light that has the rest already.
void rsv_light_restore_gathered(rsv_light *light, rsv_rgb scale);

/// Takes over the colours that some materials have now, the same all over each: another operator, of the same rows.
/// RSV_ERROR_SCENE, and all as it was, where light would never die out. @param changed [material_count]
rsv_status rsv_light_recolor(rsv_light *light, const bool *changed);

/// Light of translucent surfaces from `source` and `indirect`, without separate orders.
rsv_status rsv_light_diffuse(rsv_light *light);

/// Splits elements of direct light and caustics further where the present sources require it. Known light is carried
/// over unchanged, also between elements: the given contributions, and the light itself.
/// @param part [part_count] of this light; invalid after an error
rsv_status rsv_light_refine_levels(
    rsv_light *light, rsv_light_part *const *part, size_t part_count);

/// Solves again after sources or albedos have changed. The second logs warnings about the solution.
rsv_status rsv_light_solve(rsv_light *light);
rsv_status rsv_light_solve_again(rsv_light *light);

/// The contributions to E0, for changes; NULL = unknown.
rsv_light_basis *rsv_light_edit_basis(rsv_light *light);
/// @param basis taken over; NULL = not known any more
void rsv_light_set_basis(rsv_light *light, rsv_light_basis *basis);

/// Copies operator, E0, all results and levels from another light on the same coarse elements.
rsv_status rsv_light_assign(rsv_light *light, const rsv_light *from);
/// Copies only its levels and their fields.
rsv_status rsv_light_take_levels(rsv_light *light, const rsv_light *from);

/// A light of some of the sources on the operator, world and levels of another, with zeros for E0 and all results.
/// @param sources retained
rsv_status rsv_light_begin_like(
    const rsv_light *like, rsv_light_sources *sources, rsv_light **light);

/// The sources that a light has.
rsv_light_sources *rsv_light_get_sources(const rsv_light *light);

#endif
