/// Divides triangles until light is linear between vertices, within the tolerance.
///
/// Each triangle of a part is a quadtree down to cells of the finest elements. From the leaves up, four children are
/// merged if light in the middle of its edges is the mean of its corners. Where neighbours have different depths, the
/// larger ones are cut at the points on their edges, so that there are no cracks; so are edges with points of other
/// parts. Vertices are duplicated where light jumps: at creases, and where a wall stands on a floor.
#ifndef RSV_BAKE_TESSELLATE_H
#define RSV_BAKE_TESSELLATE_H

#include "bake_borders.h"
#include "bake_grid_light.h"
#include "bake_part.h"

typedef struct rsv_bake_mesh {
    rsv_context *context;
    uint32_t (*parent)
        [2]; ///< [attribute_count] a vertex of the file twice, or two earlier ones that it lies between
    float *
        share; ///< [attribute_count] of the second in it; NULL = there are only vertices of the file
    size_t attribute_count, attribute_capacity, share_capacity;
    uint32_t *attribute;         ///< [vertex_count] index into `parent`
    rsv_bake_receiver *receiver; ///< [vertex_count]
    rsv_rgb *light;              ///< [vertex_count] irradiance
    uint32_t *next; ///< [vertex_count] another vertex of the same attributes; RSV_NONE = last
    size_t vertex_count, vertex_capacity[4];
    uint32_t (*corner)[3]; ///< [triangle_count]
    size_t triangle_count, triangle_capacity;
    bool changed; ///< vertices are not those of the file
} rsv_bake_mesh;

typedef struct rsv_bake_tessellation {
    float finest;    ///< metres: cells are not divided below
    float tolerance; ///< relative error of light in the middle of edges
    rsv_bake_accuracy accuracy;
    bool divide; ///< false = only vertices may be doubled
} rsv_bake_tessellation;

/// A part on its way. All parts are divided before any is written, as borders are common to them.
typedef struct rsv_bake_tessellator rsv_bake_tessellator;

/// Lights a part and decides where to divide it. @param desc copied @param mesh the result
rsv_status rsv_bake_tessellator_create(const rsv_light_view *solution, const rsv_bake_part *part,
    const rsv_bake_tessellation *desc, rsv_bake_mesh *mesh, rsv_bake_tessellator **tessellator);
/// Adds the points on the edges of its triangles.
rsv_status rsv_bake_tessellator_border(
    const rsv_bake_tessellator *tessellator, rsv_bake_borders *borders);
/// @param borders of all parts, sorted
rsv_status rsv_bake_tessellator_write(
    rsv_bake_tessellator *tessellator, const rsv_bake_borders *borders);
void rsv_bake_tessellator_destroy(rsv_bake_tessellator *tessellator);

void rsv_bake_mesh_destroy(rsv_bake_mesh *mesh);

#endif
