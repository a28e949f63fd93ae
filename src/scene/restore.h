/// Restores a committed scene from stored data, bit for bit.
#ifndef RSV_RESTORE_H
#define RSV_RESTORE_H

#include "resolvent/scene.h"

/// A texture at its full resolution.
typedef struct rsv_texture_parts {
    rsv_texture_desc desc;  ///< with neither codes nor values
    const uint16_t *linear; ///< [height * width * channel_count] 0..65535 for 0..1; or
    const float *value;     ///< the same as floats
} rsv_texture_parts;

/// Everything is borrowed, nothing trusted. Of the view, textures, variations and bounds are not looked at. Its lists
/// of nodes may be NULL.
typedef struct rsv_scene_parts {
    rsv_scene_view view;
    const rsv_texture_parts *texture; ///< [view.texture_count]
} rsv_scene_parts;

/// RSV_ERROR_FORMAT for data that a committed scene cannot have: indices out of range, triangles without area, normals
/// that are not unit or point to the wrong side, and everything that the functions of scene.h refuse.
rsv_status rsv_scene_restore(rsv_context *context, const rsv_scene_parts *parts, rsv_scene **scene);

/// Gives a scene that has its textures and materials everything else of a view, and finishes it. Errors as above.
rsv_status rsv_scene_restore_rest(rsv_scene *scene, const rsv_scene_view *view);

/// The fog of a committed scene, relative to the origin. RSV_ERROR_FORMAT for fog that rsv_scene_set_fog refuses, and
/// for fog without a box.
rsv_status rsv_scene_restore_fog(rsv_scene *scene, const rsv_fog *fog);

/// The densities of that fog's box. RSV_ERROR_FORMAT or what rsv_scene_set_volume says. @param density copied
rsv_status rsv_scene_restore_volume(rsv_scene *scene, const uint32_t side[3], const float *density);

#endif
