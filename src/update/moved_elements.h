/// Coarse elements of which some moved. Cells and nodes stay what they are; what is found again is which corners and receiver
/// points other geometry buries, where something came or went.
#ifndef RSV_MOVED_ELEMENTS_H
#define RSV_MOVED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// @param scene as it is now; the elements' own view shows the same
/// @param moved [triangle_count] 1 = it moved
/// @param change boxes around all that moved, where it was and where it is; out: also around cells whose corners others stand
/// in for now, or do no longer
/// @param valid_points [node_count] in and out
/// @param anew out: [node_count] 1 = the node receives light elsewhere now
rsv_status rsv_elements_follow(const rsv_transport_scene *scene, rsv_elements *elements,
    const uint8_t *moved, rsv_scene_change *change, rsv_support_draw draw, uint16_t *valid_points,
    uint8_t *anew);

#endif
