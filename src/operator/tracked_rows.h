/// Rows that follow what moves: of each ray they keep what its end needs to be found out of date, and only rays whose way
/// touches the old or the new place of something are traced again.
///
/// A ray costs seven bytes: the node it ends at (4), how far it got (2), and what it met (1). Rays that went on through
/// mirrors, glass and coats keep the corners of their paths as well, eight bytes each. Origins and directions are made again
/// from the numbers of nodes and rays. Nodes, and so columns, stay what they are: nothing is matched, and what moves back is
/// what it was.
#ifndef RSV_TRACKED_ROWS_H
#define RSV_TRACKED_ROWS_H

#include "../update/scene_change.h"
#include "transport.h"

/// Traces all rows. Not in teams. @param desc as for rsv_transport_create; all that it borrows outlives the rows
rsv_status rsv_tracked_rows_create(const rsv_transport_desc *desc, rsv_transport **transport);

/// What moved since the rows were traced or patched.
typedef struct rsv_rows_motion {
    const rsv_lights *lights;       ///< as they are now
    const rsv_scene_change *change; ///< boxes around all that moved, where it was and where it is
    const uint8_t *anew;            ///< [row_count] 1 = all rays of the row leave from elsewhere
} rsv_rows_motion;

/// What patching took, in rays.
typedef struct rsv_rows_patched {
    uint64_t rays, traced; ///< of all rows; traced again
    size_t kept_rows;      ///< rows of which none was
} rsv_rows_patched;

/// Whether boxes lie within what trails of paths can tell; else rows must be created anew.
bool rsv_tracked_rows_can_follow(const rsv_transport *transport, const rsv_scene_change *change);

/// Traces again what a motion touched. @param transport from rsv_tracked_rows_create
rsv_status rsv_tracked_rows_patch(
    rsv_transport *transport, const rsv_rows_motion *motion, rsv_rows_patched *patched);

/// Which rows of divided elements are what they were, and where rays end now (update/divided_elements.h).
typedef struct rsv_rows_division {
    const uint32_t *row_before; ///< [row_count] RSV_NONE = none: it is traced as a whole
    const uint32_t
        *column_now; ///< [row_count of before] RSV_NONE = rays that ended there are traced again
} rsv_rows_division;

/// Rows of elements that were divided again. What is not known is traced by the next rsv_tracked_rows_patch, which must follow.
/// @param before loses what is taken over: it can only be destroyed
/// @param desc of the divided elements, with the settings of before
rsv_status rsv_tracked_rows_divide(rsv_transport *before, const rsv_transport_desc *desc,
    const rsv_rows_division *division, rsv_transport **transport);

/// Whether rows are such rows.
bool rsv_rows_are_tracked(const rsv_transport *transport);

#endif
