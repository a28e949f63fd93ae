/// Where the edges of all triangles have vertices: so that surfaces that meet have the same ones along their common
/// edge, and nothing shows between them.
#ifndef RSV_BAKE_BORDERS_H
#define RSV_BAKE_BORDERS_H

#include "../core/index_map.h"
#include "resolvent/scene.h"

typedef struct rsv_bake_borders {
    rsv_context *context;
    rsv_vec3 *point;
    size_t count, capacity;
    float near;          ///< metres: points within this distance of an edge are on it
    float cell;          ///< metres: side of the cells of a regular grid that points are found by
    rsv_index_map first; ///< of a cell: its last point
    uint32_t *next;      ///< [count] another one of the same cell; RSV_NONE = none
} rsv_bake_borders;

rsv_status rsv_bake_borders_add(rsv_bake_borders *borders, rsv_vec3 point);
/// After all were added. @param near, cell as above
rsv_status rsv_bake_borders_sort(rsv_bake_borders *borders, float near, float cell);
void rsv_bake_borders_destroy(rsv_bake_borders *borders);

/// The point on an edge, apart from its ends, that is nearest to its middle. @param share out: its place from `a` to
/// `b`
bool rsv_bake_borders_find(const rsv_bake_borders *borders, rsv_vec3 a, rsv_vec3 b, float *share);

#endif
