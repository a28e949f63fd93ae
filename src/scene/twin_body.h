/// Which of two faces of a body that lie in the same place is inside out.
#ifndef RSV_TWIN_BODY_H
#define RSV_TWIN_BODY_H

#include "twin_tree.h"

/// Whether a material is that of a body which light enters: its surface parts inside and outside, and has no front.
bool rsv_twin_is_body(const rsv_scene_view *scene, uint32_t material);

/// Whether the front of a body's face looks into the body: lines through the face cross the object's surface an odd
/// number of times on the front side, where all faces in one place count once. If the object is only a part of a
/// surface, all objects of its material are considered. False if these are not closed either.
/// @param tree of all triangles of the scene
/// @param gap maximum distance between faces in the same place, metres
bool rsv_twin_is_inside_out(
    const rsv_scene_view *scene, const rsv_twin_tree *tree, float gap, uint32_t triangle);

#endif
