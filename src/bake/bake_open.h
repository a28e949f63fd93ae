/// What of a patch can be seen. Floors run on below what stands on them, and into walls: a texel or vertex at such a border stands
/// for the part in the open alone, or light would fade to black beside every foot.
#ifndef RSV_BAKE_OPEN_H
#define RSV_BAKE_OPEN_H

#include "bake_patch.h"

#include "../solve/light.h"

typedef struct rsv_bake_cover {
    const rsv_transport_scene *scene;
    float touch; ///< m: what is closer above a surface touches it
} rsv_bake_cover;

rsv_bake_cover rsv_bake_cover_of(const rsv_light_view *solution);

/// Whether nobody sees a place: something touches it, or it lies within a body. Backs of two-sided surfaces bound a body where
/// they are close.
bool rsv_bake_is_covered(const rsv_bake_cover *cover, const rsv_surface_place *place);

/// The places of a patch that are covered, bit by bit.
uint16_t rsv_bake_covered_places(const rsv_bake_cover *cover, const rsv_bake_patch *patch);

/// Takes places out of a patch.
void rsv_bake_remove_places(rsv_bake_patch *patch, uint16_t covered);

/// Leaves of a patch what can be seen; all of it, if nothing can. @return whether something can
bool rsv_bake_keep_open(const rsv_bake_cover *cover, rsv_bake_patch *patch);

#endif
