/// Boxes around everything that moved, several where these are smaller together: a figure takes one around each limb.
#ifndef RSV_MOTION_BOXES_H
#define RSV_MOTION_BOXES_H

#include "scene_change.h"

/// Boxes around single triangles, each at its old and its new place.
typedef struct rsv_motion_boxes {
    rsv_context *context;
    rsv_vec3 *low, *high; ///< [count]
    size_t count;
} rsv_motion_boxes;

/// Where these triangles are now. @param moved [triangle_count] non-zero = it moves @param count how many do
rsv_status rsv_motion_boxes_begin(rsv_context *context, const rsv_scene_view *scene,
    const uint8_t *moved, size_t count, rsv_motion_boxes *boxes);

/// Adds where they are afterwards. @param scene, moved the same ones
void rsv_motion_boxes_end(
    rsv_motion_boxes *boxes, const rsv_scene_view *scene, const uint8_t *moved);

/// Encloses the boxes in few larger ones, without margins. Reorders them.
/// @param change without boxes in
void rsv_motion_boxes_enclose(rsv_motion_boxes *boxes, rsv_scene_change *change);

void rsv_motion_boxes_free(rsv_motion_boxes *boxes);

#endif
