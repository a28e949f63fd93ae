/// A copy of a scene in which one object stands elsewhere.
#ifndef CLI_MOVED_SCENE_H
#define CLI_MOVED_SCENE_H

#include "resolvent/scene.h"

/// The object of a scene that benchmarks move: the one of most triangles that is smaller in every direction than a
/// tenth of the scene; the first of them. RSV_NONE = there is none.
uint32_t cli_find_movable_object(const rsv_scene *scene);

/// Lower and upper ends of an object along each axis, metres.
void cli_object_bounds(const rsv_scene *scene, uint32_t object, rsv_vec3 *low, rsv_vec3 *high);

/// Metres along x.
float cli_object_extent(const rsv_scene *scene, uint32_t object);

/// Everything as it is, but one object put elsewhere. @param place column-major 4x4 that moves and turns
/// @return RSV_ERROR_UNSUPPORTED for scenes with textures
rsv_status cli_copy_scene_placed(
    const rsv_scene *scene, uint32_t object, const float place[16], rsv_scene **copy);

/// Everything as it is, but one object shifted along x. @return RSV_ERROR_UNSUPPORTED for scenes with textures
rsv_status cli_copy_scene_moved(
    const rsv_scene *scene, uint32_t object, float metres, rsv_scene **copy);

#endif
