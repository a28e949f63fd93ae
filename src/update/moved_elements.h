/// Coarse elements, some of which moved. Cells and nodes stay the same; near moved objects, the openness of corners and
/// buried receiver points are found again.
#ifndef RSV_MOVED_ELEMENTS_H
#define RSV_MOVED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// The motion, and how receiver points are drawn.
typedef struct rsv_elements_motion {
    const uint8_t *moved; ///< [triangle_count] 1 = it moved
    /// Boxes around the old and new places of everything that moved; afterwards also around cells whose corners have
    /// become buried or free.
    rsv_scene_change *change;
    rsv_support_draw draw;
    /// Out: RSV_CELL_CUT if other cells are cut than before, RSV_CELL_CUT_THROUGH if some are newly cut through; may be
    /// NULL.
    uint8_t *contacts;
} rsv_elements_motion;

/// Undoes rsv_elements_bridge_buried: every cell has its own corners again, and nodes that hang on edges both their
/// parents.
void rsv_elements_unbridge(rsv_elements *elements);

/// @param scene in its present state, which the elements' own view shares
/// @param valid_points [node_count] in and out
/// @param anew out: [node_count] 1 = the node's receiver points have changed
rsv_status rsv_elements_follow(const rsv_transport_scene *scene, rsv_elements *elements,
    const rsv_elements_motion *motion, uint16_t *valid_points, uint8_t *anew);

#endif
