/// A scene at another time of an animation. It shares everything that does not move with the scene at rest.
#ifndef RSV_SCENE_MOMENT_H
#define RSV_SCENE_MOMENT_H

#include "scene.h"

/// Gives an empty scene the materials of a committed one, in the same order, and its textures, which stay that scene's.
/// Both have the same origin. Without a camera of its own, the scene gets the first one of the scene at rest.
/// @param rest outlives it
rsv_status rsv_scene_begin_moment(rsv_scene *scene, const rsv_scene *rest);

/// Call it after everything has been added, before commit.
rsv_status rsv_scene_end_moment(rsv_scene *scene);

#endif
