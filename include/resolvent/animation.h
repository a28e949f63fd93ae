/// @file animation.h
/// Animated scenes: a glTF file at any time of its animations.
///
///     rsv_animation *animation = NULL;
///     rsv_animation_open(context, "walk.glb", NULL, &animation);
///     const rsv_clip *clip = rsv_animation_clip(animation, 0);
///     rsv_animation_scene(animation, 0, clip->start + 0.5, &scene);
///
/// Nodes, skins and morph targets move, and so do lights and cameras attached to nodes. The file is read once. A scene at
/// one time is complete: solve, update (update.h) and render it like any other.
#ifndef RESOLVENT_ANIMATION_H
#define RESOLVENT_ANIMATION_H

#include "resolvent/io.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A file that is kept open. One call at a time.
typedef struct rsv_animation rsv_animation;

/// What can be played.
typedef struct rsv_clip {
    const char *name;     ///< "animation 0", ... where the file has none
    double start, end;    ///< s: the first and the last key
    size_t channel_count; ///< that move something here
} rsv_clip;

/// Reads the animations of a file, and of the rest what rsv_scene_load_with reads before there are vertices.
/// RSV_ERROR_UNSUPPORTED for formats other than glTF; RSV_ERROR_FORMAT, with the animation's name, for keys that are out of
/// order, missing or not finite. Without any animation there are no clips.
/// @param desc NULL = defaults; what it lists must outlive the animation; no document is kept (rsv_load_desc.keep_document): what it says is where things are at rest
RSV_API rsv_status rsv_animation_open(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_animation **animation);

/// After all scenes that came from it. NULL is allowed.
RSV_API void rsv_animation_destroy(rsv_animation *animation);

RSV_API size_t rsv_animation_clip_count(const rsv_animation *animation);

/// @param index below the count @return valid as long as the animation
RSV_API const rsv_clip *rsv_animation_clip(const rsv_animation *animation, size_t index);

/// The first clip of a name; RSV_NONE if there is none.
RSV_API uint32_t rsv_animation_find_clip(const rsv_animation *animation, const char *name);

/// The scene at a moment, committed. Textures are those of the animation, which outlives it. A scene without a camera is
/// shown by the one that frames it at rest.
/// @param clip RSV_NONE = all clips at once; where two move the same, the later one counts
/// @param time s, finite; before the first key of a channel its value stays, and after the last one that
RSV_API rsv_status rsv_animation_scene(
    rsv_animation *animation, uint32_t clip, double time, rsv_scene **scene);

#ifdef __cplusplus
}
#endif

#endif
