/// Meshes of formats that have no materials, and leave unit and upward axis open.
#ifndef RSV_BARE_MESH_H
#define RSV_BARE_MESH_H

#include "../scene/scene.h"
#include "resolvent/io.h"

/// A white material of albedo 0.8, the same on both sides.
rsv_status rsv_add_bare_material(rsv_scene *scene, uint32_t *material);

/// Coordinates as they stand in a file.
typedef struct rsv_place {
    double at[3];
} rsv_place;

/// Converts coordinates to those of a mesh. If all lie far from the origin, their common offset is subtracted.
/// @param origin out: the offset @param position out: [count]
void rsv_bring_near(const rsv_place *place, size_t count, double origin[3], rsv_vec3 *position);

/// Adds a mesh and an instance of it. Without normals it is shaded smooth, except across creases.
/// @param origin what was subtracted from the positions, in the file's unit
/// @param in_single whether the file stores single precision @param mesh its indices must be below vertex_count
rsv_status rsv_add_bare_mesh(rsv_scene *scene, const rsv_load_desc *desc, const double origin[3],
    bool in_single, rsv_mesh_desc mesh);

#endif
