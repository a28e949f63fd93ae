/// Places where other geometry touches or cuts the elements: the classic cause of light leaks.
///
/// A floor that continues under a wall is one surface for interpolation, but two for light. Cells that the wall cuts
/// are split until the error is confined to a thin line. Nodes around which the wall separates cells become one node
/// per side.
#ifndef RSV_CONTACT_H
#define RSV_CONTACT_H

#include "../specular/specular_path.h"
#include "elements.h"

/// How much larger than usual a cell may be, at least 1. Any thread.
typedef struct rsv_growth {
    float (*at)(const void *user, const rsv_elements *elements, uint32_t cell);
    const void *user;
} rsv_growth;

/// Splits cells that other geometry cuts, at most twice; those that reach from one side of a thin wall to the other, at
/// most four times. Cells far smaller than the spacing are left alone. So are larger ones if meshes intersect so much
/// that there would be too many nodes. Replaces `*elements`.
/// @param most_nodes approximate limit of added nodes
/// @param growth factor by which cells have been made larger than usual. They may stay larger by its square, except
/// those that reach through walls; NULL = 1
rsv_status rsv_elements_refine_contacts(const rsv_transport_scene *scene, size_t most_nodes,
    const rsv_growth *growth, rsv_elements **elements, uint64_t *rays);

/// Size above which contacts of these elements were split: that of cut cells that were left whole, except for a few.
/// Later contacts are split as finely.
float rsv_elements_contact_size(const rsv_elements *elements);

/// Whether other geometry cuts a cell that would have been split for that. @param least metres, from
/// rsv_elements_contact_size; 0 = independent of other contacts
bool rsv_cell_wants_contact_split(const rsv_elements *elements, uint32_t cell, float least);

/// Gives every side of a wall its own nodes where the wall runs along edges of cells, or covers the node between them.
/// @param earlier elements of the same faces on which that was done: only where cells changed since may there be more
/// to
///                do; NULL = everywhere
rsv_status rsv_elements_separate(const rsv_transport_scene *scene, const rsv_elements *earlier,
    rsv_elements *elements, uint64_t *rays);

#endif
