/// Visible parts of patches. Floors continue under objects on them, and into walls. A texel or vertex at such a border
/// represents only the visible part, otherwise light would fade to black next to every object.
#ifndef RSV_BAKE_OPEN_H
#define RSV_BAKE_OPEN_H

#include "bake_patch.h"

#include "../solve/light.h"

typedef struct rsv_bake_cover {
    const rsv_transport_scene *scene;
    float touch; ///< m: geometry closer than this above a surface touches it
} rsv_bake_cover;

rsv_bake_cover rsv_bake_cover_of(const rsv_light_view *solution);

/// Whether a place is hidden: something touches it, or it is inside a body. Backs of two-sided surfaces bound a body if
/// they are close.
bool rsv_bake_is_covered(const rsv_bake_cover *cover, const rsv_surface_place *place);

/// The places of a patch that are covered, bit by bit.
uint16_t rsv_bake_covered_places(const rsv_bake_cover *cover, const rsv_bake_patch *patch);

/// Takes places out of a patch.
void rsv_bake_remove_places(rsv_bake_patch *patch, uint16_t covered);

/// Reduces a patch to its visible part, or leaves it unchanged if nothing is visible. @return whether something is
bool rsv_bake_keep_open(const rsv_bake_cover *cover, rsv_bake_patch *patch);

#endif
