/// Coarse elements of which some moved. Cells and nodes stay what they are; what is found again is which corners and receiver
/// points other geometry buries, where something came or went.
#ifndef RSV_MOVED_ELEMENTS_H
#define RSV_MOVED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// What moved, and how receiver points are drawn.
typedef struct rsv_elements_motion {
    const uint8_t *moved; ///< [triangle_count] 1 = it moved
    /// Boxes around all that moved, where it was and where it is; in the end also around cells whose corners others stand in
    /// for now, or do no longer.
    rsv_scene_change *change;
    rsv_support_draw draw;
    /// Out: RSV_CELL_CUT where other cells are cut now than before, with RSV_CELL_CUT_THROUGH where some are newly cut
    /// through; NULL = nobody asks.
    uint8_t *contacts;
} rsv_elements_motion;

/// Undoes rsv_elements_bridge_buried: every cell has its own corners again, and nodes that hang on edges both their parents.
void rsv_elements_unbridge(rsv_elements *elements);

/// @param scene as it is now; the elements' own view shows the same
/// @param valid_points [node_count] in and out
/// @param anew out: [node_count] 1 = the node receives light elsewhere now
rsv_status rsv_elements_follow(const rsv_transport_scene *scene, rsv_elements *elements,
    const rsv_elements_motion *motion, uint16_t *valid_points, uint8_t *anew);

#endif
