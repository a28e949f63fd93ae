/// Steps of creating elements, and their common data.
#ifndef RSV_ELEMENTS_INTERNAL_H
#define RSV_ELEMENTS_INTERNAL_H

#include "elements.h"
#include "spacing.h"

/// Only the data common to all elements of a scene.
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

/// Nodes, hanging nodes and supports of finished cells.
/// @param unbalanced out, freed by the caller: cells with an edge halved more than once. If there are any, no nodes are
/// created, because these cells must be split first
rsv_status rsv_elements_number_nodes(
    rsv_elements *elements, uint8_t **unbalanced, bool *any_unbalanced);

/// Fails where places, 4 * cell + corner, have no room in 32 bits.
rsv_status rsv_elements_are_countable(const rsv_elements *elements);

/// Supports, faces and areas of numbered nodes.
rsv_status rsv_elements_create_supports(rsv_elements *elements);

/// Areas of the hat functions, those of hanging nodes with their parents.
void rsv_elements_find_node_areas(rsv_elements *elements);

#endif
