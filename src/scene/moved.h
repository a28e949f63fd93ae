/// Differences between two versions of a scene: the parts whose positions differ.
#ifndef RSV_SCENE_MOVED_H
#define RSV_SCENE_MOVED_H

#include "scene.h"

/// How a version of a scene differs from another one of the same surfaces.
typedef struct rsv_scene_difference {
    uint8_t *moved; ///< [triangle_count] 1 = corners or normals are elsewhere
    size_t moved_count;
    bool lights_moved; ///< punctual lights shine from elsewhere, or otherwise
} rsv_scene_difference;

/// Compares two versions. RSV_ERROR_UNSUPPORTED, with a message that says why, if they differ in triangles, objects,
/// materials or lights, so that the second must be solved from scratch.
/// @param difference out; free `moved`, also after an error
rsv_status rsv_scene_find_moved(
    const rsv_scene *scene, const rsv_scene *version, rsv_scene_difference *difference);

/// Copies the positions of all vertices, punctual lights and cameras from a version that was compared with this one.
/// Call rsv_scene_update_bounds afterwards to update bounds and duplicate faces.
/// @param variant with its own vertices and normals (variant.h)
void rsv_scene_take_places(rsv_scene *variant, const rsv_scene *version);

#endif
