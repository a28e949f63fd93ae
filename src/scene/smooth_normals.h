/// Shading normals for meshes that come without.
#ifndef RSV_SMOOTH_NORMALS_H
#define RSV_SMOOTH_NORMALS_H

#include "scene.h"

/// A mesh whose vertices are split where it is creased.
typedef struct rsv_smooth_mesh {
    rsv_vec3 *normal; ///< [vertex_count] unit, or zero where only degenerate triangles meet
    uint32_t *source; ///< [vertex_count] vertex of the original mesh
    uint32_t *index;  ///< [3 * triangle_count]
    size_t vertex_count;
} rsv_smooth_mesh;

/// Triangles at an edge are smoothed across it if they meet at less than `crease_angle`. The normal of a vertex is the
/// mean over such triangles around it, weighted by their angles there (Thürmer and Wüthrich 1998), so that it does not
/// depend on how faces are divided into triangles. Vertices with identical positions count as one.
/// @param mesh its positions and indices, each below its vertex_count
/// @param crease_angle radians; pi or more = smooth everywhere
rsv_status rsv_smooth_normals(
    rsv_context *context, const rsv_mesh_desc *mesh, float crease_angle, rsv_smooth_mesh *smooth);

void rsv_smooth_mesh_release(rsv_context *context, rsv_smooth_mesh *smooth);

#endif
