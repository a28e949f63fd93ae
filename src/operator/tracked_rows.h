/// Rows that follow moving objects. Enough is stored of each ray to know whether it is out of date, and only rays that
/// touch the old or new place of an object are traced again.
///
/// A ray takes seven bytes: the node where it ends (4), how far it got (2), and what it hit (1). Rays that continued
/// through mirrors, glass and coats also store the corners of their paths, eight bytes each. Origins and directions are
/// computed again from the numbers of nodes and rays. Nodes, and so columns, keep their numbers: nothing has to be
/// matched, and an object that moves back gives the original rows.
#ifndef RSV_TRACKED_ROWS_H
#define RSV_TRACKED_ROWS_H

#include "../update/scene_change.h"
#include "transport.h"

/// Traces all rows. Not for teams. @param desc as for rsv_transport_create; everything that it borrows must outlive the
/// rows
rsv_status rsv_tracked_rows_create(const rsv_transport_desc *desc, rsv_transport **transport);

/// Motion since the rows were traced or patched.
typedef struct rsv_rows_motion {
    const rsv_lights *lights; ///< as they are now
    const rsv_scene_change
        *change;         ///< boxes around the old and new places of everything that moved
    const uint8_t *anew; ///< [row_count] RSV_MOVE_... of the places that a row's rays leave from
    /// Rows are patched if their number leaves the remainder `turn` when divided by `turns`, or if their rays leave
    /// from other places; others stay as they are. 0 = all are patched.
    uint32_t turns, turn;
} rsv_rows_motion;

/// Cost of patching, in rays.
typedef struct rsv_rows_patched {
    uint64_t rays, traced; ///< of all rows; traced again
    size_t kept_rows;      ///< rows of which none was
} rsv_rows_patched;

/// Whether the boxes are within the range of stored paths; otherwise rows must be created again.
bool rsv_tracked_rows_can_follow(const rsv_transport *transport, const rsv_scene_change *change);

/// Traces the rays affected by a motion again. @param transport from rsv_tracked_rows_create
rsv_status rsv_tracked_rows_patch(
    rsv_transport *transport, const rsv_rows_motion *motion, rsv_rows_patched *patched);

/// Rows of divided elements that have not changed, and the new ends of rays (update/divided_elements.h).
typedef struct rsv_rows_division {
    const uint32_t *row_before; ///< [row_count] RSV_NONE = none: it is traced as a whole
    const uint32_t
        *column_now; ///< [row_count of before] RSV_NONE = rays that ended there are traced again
} rsv_rows_division;

/// Rows of elements that were divided again. The next rsv_tracked_rows_patch, which must follow, traces the missing
/// rays.
/// @param before loses the rows that are reused, and can then only be destroyed
/// @param desc of the divided elements, with the original settings
rsv_status rsv_tracked_rows_divide(rsv_transport *before, const rsv_transport_desc *desc,
    const rsv_rows_division *division, rsv_transport **transport);

/// Whether rows are such rows.
bool rsv_rows_are_tracked(const rsv_transport *transport);

#endif
