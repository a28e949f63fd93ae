/// @file io.h
/// Scenes from and to files.
#ifndef RESOLVENT_IO_H
#define RESOLVENT_IO_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Reads a glTF 2.0 scene (.gltf, .glb) and commits it. Messages name file, node, mesh, material and
/// accessor. Files are treated as hostile: every size and index is checked.
RSV_API rsv_status rsv_scene_load(rsv_context *context, const char *path, rsv_scene **scene);

/// Writes a committed scene as binary glTF; what rsv_scene_load reads back is the same scene. The file
/// appears complete or not at all.
RSV_API rsv_status rsv_scene_save(const rsv_scene *scene, const char *path);

#ifdef __cplusplus
}
#endif

#endif
