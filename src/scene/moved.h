/// The same surfaces elsewhere: what of a scene is not where it is in another version of it.
#ifndef RSV_SCENE_MOVED_H
#define RSV_SCENE_MOVED_H

#include "scene.h"

/// How a version of a scene differs from another one of the same surfaces.
typedef struct rsv_scene_difference {
    uint8_t *moved; ///< [triangle_count] 1 = corners or normals are elsewhere
    size_t moved_count;
    bool lights_moved; ///< punctual lights shine from elsewhere, or otherwise
} rsv_scene_difference;

/// Compares two versions. RSV_ERROR_UNSUPPORTED, and a message that says why, where the second has other triangles, objects,
/// materials or lights than the first: it must be solved anew.
/// @param difference out; `moved` is to be freed, even after an error
rsv_status rsv_scene_find_moved(
    const rsv_scene *scene, const rsv_scene *version, rsv_scene_difference *difference);

/// Takes over the places of all vertices, punctual lights and cameras of a version that was compared with it. Bounds and what
/// lies upon each other are found by rsv_scene_update_bounds.
/// @param variant with vertices and normals of its own (variant.h)
void rsv_scene_take_places(rsv_scene *variant, const rsv_scene *version);

#endif
