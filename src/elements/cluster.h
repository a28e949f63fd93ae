/// Meshes finer than the wanted spacing: most of their vertices need no row of their own.
#ifndef RSV_CLUSTER_H
#define RSV_CLUSTER_H

#include "elements.h"

/// Keeps some nodes of finely meshed surfaces as leaders and lets the others follow: a follower's value is a smooth
/// weighted mean of the leaders around it, so the field stays continuous and shows no facets.
///
/// Distance runs along the edges of cells, so that it leads neither across creases and walls nor through thin
/// bodies, and a turn of the surface counts like a way: a small ball keeps leaders on all sides. Only nodes whose
/// cells are whole triangles follow; grids and split cells have the size that somebody asked for.
/// @param radius metres, halved `face_halvings` times: every follower has a leader within it, and is led by those within
/// twice of it
rsv_status rsv_elements_cluster(rsv_elements *elements, float radius);

/// As it is at a cell.
RSV_INLINE float rsv_cluster_radius_at(const rsv_elements *e, uint32_t cell)
{
    return ldexpf(e->cluster_radius, -e->face_halvings[e->cell[cell].face]);
}

#endif
