/// @file animation.h
/// Animated scenes: a glTF file at any time of its animations.
///
///     rsv_animation *animation = NULL;
///     rsv_animation_open(context, "walk.glb", NULL, &animation);
///     const rsv_clip *clip = rsv_animation_clip(animation, 0);
///     rsv_animation_scene(animation, 0, clip->start + 0.5, &scene);
///
/// Nodes, skins and morph targets move, and so do lights and cameras attached to nodes. The file is read once. A scene
/// at one time is complete: solve, update (update.h) and render it like any other.
#ifndef RESOLVENT_ANIMATION_H
#define RESOLVENT_ANIMATION_H

#include "resolvent/io.h"

#ifdef __cplusplus
extern "C" {
#endif

/// An open animated file. Not thread-safe.
typedef struct rsv_animation rsv_animation;

/// An animation of the file.
typedef struct rsv_clip {
    const char *name;     ///< "animation 0", ... if it has no name
    double start, end;    ///< s: times of the first and last key
    size_t channel_count; ///< channels that move something in the scene
} rsv_clip;

/// Opens a file and reads its animations. A file without animations has no clips.
/// @param desc NULL = defaults. What it refers to must outlive the animation. No document is kept
/// (rsv_load_desc.keep_document), because a document describes the scene at rest
/// @return RSV_ERROR_UNSUPPORTED for formats other than glTF; RSV_ERROR_FORMAT, with the animation's name, for keys
/// that are missing, out of order or not finite
RSV_API rsv_status rsv_animation_open(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_animation **animation);

/// The animations of the glTF file that a scene keeps (rsv_load_desc.keep_document), such as the scene of an operator
/// file, for a light to follow (rsv_light_follow). Its scenes have the materials, the strengths of lights and, if the
/// file has none, the first camera of `scene`, but no environment and no fog.
/// @param scene committed; must outlive the animation
/// @return RSV_ERROR_UNSUPPORTED if it keeps no file, or if lights were moved, added or replaced since it was read
RSV_API rsv_status rsv_animation_open_document(const rsv_scene *scene, rsv_animation **animation);

/// Destroy all scenes from the animation first. NULL is allowed.
RSV_API void rsv_animation_destroy(rsv_animation *animation);

RSV_API size_t rsv_animation_clip_count(const rsv_animation *animation);

/// @param index below the count @return valid until the animation is destroyed
RSV_API const rsv_clip *rsv_animation_clip(const rsv_animation *animation, size_t index);

/// Index of the first clip with that name; RSV_NONE if there is none.
RSV_API uint32_t rsv_animation_find_clip(const rsv_animation *animation, const char *name);

/// The scene at a given time, committed. The animation owns its textures, and must outlive it. If the file has no
/// camera, the scene gets one that shows all of it at rest.
/// @param clip RSV_NONE = all clips at once; if two move the same thing, the later one counts
/// @param time s, finite. Before its first key and after its last, a channel keeps the value of that key
RSV_API rsv_status rsv_animation_scene(
    rsv_animation *animation, uint32_t clip, double time, rsv_scene **scene);

#ifdef __cplusplus
}
#endif

#endif
