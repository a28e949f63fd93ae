/// Changing a light in place: other strengths, places and colours, and what follows from them. For rooms that relight.
#ifndef RSV_LIGHT_CHANGE_H
#define RSV_LIGHT_CHANGE_H

#include "light.h"

/// Gives a light a world of its own, whose scene may be changed, where it still has that of its operator.
rsv_status rsv_light_vary_world(rsv_light *light);

/// The world of a light. Its `variant` is there after that.
rsv_world *rsv_light_world(rsv_light *light);

/// Fields to write to. What is written shows after rsv_light_publish.
rsv_light_fields *rsv_light_edit(rsv_light *light);

/// Brings the view up to date.
void rsv_light_publish(rsv_light *light);

/// Finds sources again after the scene's strengths, places and colours changed.
/// @param like lights of the same scene: what they gather is gathered
rsv_status rsv_light_find_sources(rsv_light *light, const rsv_lights *like);

/// Takes over how strong sources are, the environment being as it was. @param followed as in rsv_lights_follow_strengths
rsv_status rsv_light_follow_strengths(rsv_light *light, bool *followed);

/// Lets triangles of some materials be moved in the light's own scene. @param moves [material_count]
rsv_status rsv_light_vary_places(rsv_light *light, const bool *moves);

/// Takes over where sources stand, nothing else having changed.
rsv_status rsv_light_follow_places(rsv_light *light);

/// Sets the factor of the emission that rows gathered, and adds that, what rows see of the surroundings, and caustics to the
/// next-event estimates that `source` was set to.
void rsv_light_gather(rsv_light *light, rsv_rgb scale);

/// Sets that factor alone, of a light that has the rest already.
void rsv_light_restore_gathered(rsv_light *light, rsv_rgb scale);

/// Takes over the colours that some materials have now, the same all over each: another operator, of the same rows.
/// RSV_ERROR_SCENE, and all as it was, where light would never die out. @param changed [material_count]
rsv_status rsv_light_recolor(rsv_light *light, const bool *changed);

/// What translucent surfaces show of `source` and `indirect`, bounces not kept apart.
rsv_status rsv_light_diffuse(rsv_light *light);

/// Splits elements of direct light and caustics further, where sources as they stand now ask for that. What is known there is
/// carried over and stays what it was, also between elements: those parts that are given, and the light itself.
/// @param part [part_count] of this light; after an error they may be used no more
rsv_status rsv_light_refine_levels(
    rsv_light *light, rsv_light_part *const *part, size_t part_count);

/// Solves again, after sources or albedos changed. The second says in the log what a reader must know.
rsv_status rsv_light_solve(rsv_light *light);
rsv_status rsv_light_solve_again(rsv_light *light);

/// The parts of E0, to be changed with it; NULL = not known.
rsv_light_basis *rsv_light_edit_basis(rsv_light *light);
/// @param basis taken over; NULL = not known any more
void rsv_light_set_basis(rsv_light *light, rsv_light_basis *basis);

/// Makes operator, E0 and all that follows from it those of another light on the same coarse elements; its levels too.
rsv_status rsv_light_assign(rsv_light *light, const rsv_light *from);
/// Its levels alone, and what they hold.
rsv_status rsv_light_take_levels(rsv_light *light, const rsv_light *from);

/// A light of some of the sources on the operator, world and levels of another, with zeros for E0 and all that follows.
/// @param sources retained
rsv_status rsv_light_begin_like(
    const rsv_light *like, rsv_light_sources *sources, rsv_light **light);

/// The sources that a light has.
rsv_light_sources *rsv_light_get_sources(const rsv_light *light);

#endif
