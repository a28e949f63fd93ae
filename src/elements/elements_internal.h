/// Steps of creating elements, and what they share.
#ifndef RSV_ELEMENTS_INTERNAL_H
#define RSV_ELEMENTS_INTERNAL_H

#include "elements.h"
#include "spacing.h"

/// Nothing but what all elements of a scene share.
rsv_status rsv_elements_create_empty(const rsv_scene_view *scene, const rsv_bsdf *bsdf,
    float spacing, rsv_context *context, rsv_elements **elements);

/// Every scattering side of every triangle, welded to its neighbours.
rsv_status rsv_elements_create_faces(rsv_elements *elements);
rsv_status rsv_elements_copy_faces(const rsv_elements *from, rsv_elements *to);

/// Whether light that arrives on a side of a triangle is scattered diffusely, and so has elements.
bool rsv_side_scatters(const rsv_bsdf *bsdf, bool back);

/// Regular grids, whose cells are as large as the largest of the face may be.
rsv_status rsv_elements_create_grid(rsv_elements *elements, const rsv_spacing *spacing);

/// The cells of `coarser`, those marked replaced by their four children.
rsv_status rsv_elements_split_cells(
    const rsv_elements *coarser, const uint8_t *split, rsv_elements *finer);

/// The children of a cell: 0..2 keep a corner of the parent, 3 is the middle one, turned over.
rsv_cell rsv_child_cell(rsv_cell parent, int k);

/// Nodes, hanging nodes and supports of finished cells.
/// @param unbalanced out, to be freed by the caller: cells with an edge halved more than once; where there are any,
/// nodes are left out, as such cells are to be split
rsv_status rsv_elements_number_nodes(
    rsv_elements *elements, uint8_t **unbalanced, bool *any_unbalanced);

/// Fails where places, 4 * cell + corner, have no room in 32 bits.
rsv_status rsv_elements_are_countable(const rsv_elements *elements);

/// Supports, faces and areas of numbered nodes.
rsv_status rsv_elements_create_supports(rsv_elements *elements);

/// Area of a cell, m2.
RSV_INLINE float rsv_cell_area(const rsv_elements *elements, uint32_t cell)
{
    const rsv_cell *c = &elements->cell[cell];
    return elements->face_area[c->face] / (float)(1u << (2 * c->level));
}

#endif
