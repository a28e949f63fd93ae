/// @file edit.h
/// Edited scenes: objects removed or repeated, and other materials. To move objects, see rsv_scene_move (scene.h).
/// Scenes between two versions.
///
///     const uint32_t kept[] = { 0, 1, 3, 3 };            // without object 2, and with object 3 twice
///     rsv_scene_edit edit = rsv_default_scene_edit();
///     edit.object = kept;
///     edit.object_count = 4;
///     rsv_scene_apply_edit(room, &edit, &edited);
///     rsv_operator_update(edited, &solve, store, &light, NULL); // for a part of the cost of a solve
#ifndef RESOLVENT_EDIT_H
#define RESOLVENT_EDIT_H

#include "resolvent/scene.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// New values of a material. With textures, they are factors, as in rsv_material.
typedef struct rsv_material_edit {
    uint32_t material; ///< of the scene
    rsv_rgb base_color;
    float roughness, metallic; ///< 0 to 1
} rsv_material_edit;

/// What becomes of a scene. Start from rsv_default_scene_edit().
typedef struct rsv_scene_edit {
    size_t size;            ///< sizeof this structure; rsv_default_scene_edit() sets it
    const uint32_t *object; ///< [object_count] objects of the scene, in the order of the edited one; NULL = all
    size_t object_count;
    const rsv_material_edit *material; ///< [material_count]
    size_t material_count;
} rsv_scene_edit;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_scene_edit().
RSV_API void rsv_scene_edit_init(rsv_scene_edit *edit, size_t size);
static inline rsv_scene_edit rsv_default_scene_edit(void)
{
    rsv_scene_edit edit;
    rsv_scene_edit_init(&edit, sizeof edit);
    return edit;
}

/// Creates an edited scene, committed, with the lights, cameras and environment of the original. Vertices stay the same
/// bit for bit, so that rsv_operator_update recognises what is unchanged. Repeated objects are in the same place until
/// they are moved.
/// @param scene committed; must outlive the result, which shares its textures
/// @return RSV_ERROR_SCENE if nothing is left, RSV_ERROR_UNSUPPORTED for scenes with fog
RSV_API rsv_status rsv_scene_apply_edit(
    const rsv_scene *scene, const rsv_scene_edit *edit, rsv_scene **result);

/// Creates a version of a scene between two others: some objects are where they are in `late`, the rest where they are in
/// `early`. Lights are those of `late`. For motions that a light follows object by object (rsv_light_follow), because
/// all at once would take too long.
/// @param late committed; must outlive the result @param early of the same surfaces; RSV_ERROR_ARGUMENT otherwise
/// @param moved [object_count] whether the object is where it is in `late`
RSV_API rsv_status rsv_scene_mix(
    const rsv_scene *early, const rsv_scene *late, const bool *moved, rsv_scene **result);

#ifdef __cplusplus
}
#endif

#endif
