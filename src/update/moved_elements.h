/// Coarse elements, some of which moved. Cells and nodes stay the same; near moved objects, the openness of corners and
/// buried receiver points are found again.
#ifndef RSV_MOVED_ELEMENTS_H
#define RSV_MOVED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// Whether a triangle, or the receiver points of a node, are elsewhere than when their light was computed.
enum {
    RSV_MOVE_NONE,  ///< no
    RSV_MOVE_TURN,  ///< yes, and their light is computed again now
    RSV_MOVE_WAITS, ///< yes, but they keep the light that they have for now
};

/// The motion, and how receiver points are drawn.
typedef struct rsv_elements_motion {
    const uint8_t *moved; ///< [triangle_count] RSV_MOVE_...
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

/// Whether a node keeps its light for now. One of its faces decides for all of them.
/// @param moved [triangle_count] RSV_MOVE_...
bool rsv_node_waits(const rsv_elements *elements, uint32_t node, const uint8_t *moved);

/// @param scene in its present state, which the elements' own view shares
/// @param valid_points [node_count] in and out
/// @param anew out: [node_count] RSV_MOVE_... of the node's receiver points
rsv_status rsv_elements_follow(const rsv_transport_scene *scene, rsv_elements *elements,
    const rsv_elements_motion *motion, uint16_t *valid_points, uint8_t *anew);

#endif
