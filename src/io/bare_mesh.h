/// Meshes of formats that have no materials, and leave unit and upward axis open.
#ifndef RSV_BARE_MESH_H
#define RSV_BARE_MESH_H

#include "../scene/scene.h"
#include "resolvent/io.h"

/// White of albedo 0.8, both sides alike.
rsv_status rsv_add_bare_material(rsv_scene *scene, uint32_t *material);

/// Adds a mesh and its place; without normals it is smooth but for its creases.
/// @param mesh indices below vertex_count
rsv_status rsv_add_bare_mesh(rsv_scene *scene, const rsv_load_desc *desc, rsv_mesh_desc mesh);

/// The whole of a file, at most 4 GiB, with a zero behind it. @param bytes out: to be released by rsv_free
rsv_status rsv_read_whole(rsv_context *context, const char *path, char **bytes, size_t *size);

#endif
