/// Smooth bodies given by a function of space.
#ifndef RSV_ISOSURFACE_H
#define RSV_ISOSURFACE_H

#include "shapes.h"

/// Negative inside, positive outside, smooth near 0.
typedef float (*rsv_field)(rsv_vec3 point);

/// Triangles and unit normals of a field's zero surface; arrays belong to the context given.
typedef struct rsv_isosurface {
    rsv_vec3 *position, *normal; ///< [vertex_count]
    uint32_t *index;             ///< [3 * triangle_count]
    size_t vertex_count, triangle_count;
    size_t vertex_capacity, normal_capacity, index_capacity;
} rsv_isosurface;

/// Marching tetrahedra: each cell of a cubic grid is divided into six tetrahedra around its diagonal (Kuhn), and each
/// of these contributes one or two triangles. Vertices are then moved onto the surface along the gradient. The mesh is
/// closed if the surface stays within the box.
/// @param cells along the longest side of the box
rsv_status rsv_isosurface_create(rsv_context *context, rsv_field field, rsv_vec3 low, rsv_vec3 high,
    uint32_t cells, rsv_isosurface *surface);
void rsv_isosurface_release(rsv_context *context, rsv_isosurface *surface);

/// The same with cells so small that there are about `triangles` (100 or more).
rsv_status rsv_isosurface_of_size(rsv_context *context, rsv_field field, rsv_vec3 low,
    rsv_vec3 high, size_t triangles, rsv_isosurface *surface);

#endif
