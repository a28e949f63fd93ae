/// Meshes finer than required: most of their vertices need no row of their own.
#ifndef RSV_CLUSTER_H
#define RSV_CLUSTER_H

#include "elements.h"

/// On finely meshed surfaces, keeps some nodes as leaders and makes the others followers. The value of a follower is a
/// smooth weighted mean of the leaders around it, so the field remains continuous and shows no facets.
///
/// Distance is measured along the edges of cells, so that followers do not reach across creases, walls or thin bodies.
/// Turns of the surface add to it: a small ball keeps leaders on all sides. Only nodes of whole triangles follow; grids
/// and split cells already have the required size.
/// @param radius metres, halved `face_halvings` times: every follower has a leader within it, and depends on those
/// within twice of it
rsv_status rsv_elements_cluster(rsv_elements *elements, float radius);

/// As it is at a cell.
RSV_INLINE float rsv_cluster_radius_at(const rsv_elements *e, uint32_t cell)
{
    return ldexpf(e->cluster_radius, -e->face_halvings[e->cell[cell].face]);
}

#endif
