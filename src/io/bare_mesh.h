/// Meshes of formats that have no materials, and leave unit and upward axis open.
#ifndef RSV_BARE_MESH_H
#define RSV_BARE_MESH_H

#include "../scene/scene.h"
#include "resolvent/io.h"

/// White of albedo 0.8, both sides alike.
rsv_status rsv_add_bare_material(rsv_scene *scene, uint32_t *material);

/// Coordinates as they stand in a file.
typedef struct rsv_place {
    double at[3];
} rsv_place;

/// Coordinates as meshes have them, less what all have in common where that is far from the origin.
/// @param origin out: what was taken out @param position out: [count]
void rsv_bring_near(const rsv_place *place, size_t count, double origin[3], rsv_vec3 *position);

/// Adds a mesh and its place; without normals it is smooth but for its creases.
/// @param origin what its positions are less, in units of the file @param in_single whether the file has single precision
/// @param mesh indices below vertex_count
rsv_status rsv_add_bare_mesh(rsv_scene *scene, const rsv_load_desc *desc, const double origin[3],
    bool in_single, rsv_mesh_desc mesh);

#endif
