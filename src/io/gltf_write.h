/// A committed scene as binary glTF in memory (rsv_scene_save writes the same to a file).
#ifndef RSV_GLTF_WRITE_H
#define RSV_GLTF_WRITE_H

#include "resolvent/scene.h"

/// Each object becomes a node with a mesh. They come first, in order, and keep the order of their triangles.
/// @param bytes out: [count], to be freed with rsv_free
rsv_status rsv_scene_write_document(const rsv_scene *scene, uint8_t **bytes, size_t *count);

#endif
