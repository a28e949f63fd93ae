/// Which of two faces of a body that lie in the same place is inside out.
#ifndef RSV_TWIN_BODY_H
#define RSV_TWIN_BODY_H

#include "twin_tree.h"

/// Whether a material is that of a body which light enters: its surface parts inside and outside, and has no front.
bool rsv_twin_is_body(const rsv_scene_view *scene, uint32_t material);

/// Whether the front of a body's face looks into the body. Lines through the face cross the surface of the object an odd
/// number of times on its inner side, each place counting once however many faces lie there. Where the object is a piece
/// of a surface, all of its material are looked at. False if that is not closed either.
/// @param tree of all of the scene's triangles @param gap metres that faces at one place lie apart at most
bool rsv_twin_is_inside_out(
    const rsv_scene_view *scene, const rsv_twin_tree *tree, float gap, uint32_t triangle);

#endif
