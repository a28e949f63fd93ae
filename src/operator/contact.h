/// Where other geometry stands on or cuts through the elements: the classic place of light leaks.
///
/// A floor that runs on under a wall is one surface to interpolation but two to light. Cells through
/// which the wall passes are split until the error is confined to a thin line; nodes around which the wall
/// separates cells become one node per side.
#ifndef RSV_CONTACT_H
#define RSV_CONTACT_H

#include "elements.h"
#include "resolvent/trace.h"

/// A cell in space.
typedef struct rsv_cell_shape {
    rsv_vec3 corner[3], centre;
    rsv_vec3 normal; ///< unit, geometric
    float size;      ///< edge of a right triangle of its area
    float extent;    ///< for rsv_offset_origin
} rsv_cell_shape;

rsv_cell_shape rsv_cell_shape_of(const rsv_elements *elements, uint32_t cell);

/// A place above the cell by a small part of its size, and a little towards its centre, so that what merely
/// touches its border is not met. Gaps below that height count as contact.
rsv_vec3 rsv_cell_hover(const rsv_cell_shape *shape, rsv_vec3 place);

/// Whether something lies right upon the cell, between a place and where it hovers.
bool rsv_is_covered(const rsv_tracer *tracer, const rsv_cell_shape *shape, rsv_vec3 place);

/// Whether anything stands between two places.
bool rsv_is_blocked(const rsv_tracer *tracer, rsv_vec3 from, rsv_vec3 to);

/// Splits cells that other geometry cuts, `levels` times at most. Replaces `*elements`.
rsv_status rsv_elements_refine_contacts(
    const rsv_tracer *tracer, uint32_t levels, rsv_elements **elements, uint64_t *rays);

/// Gives every side of a wall its own nodes where the wall runs along edges of cells.
rsv_status rsv_elements_separate(const rsv_tracer *tracer, rsv_elements *elements, uint64_t *rays);

#endif
