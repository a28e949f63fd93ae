/// Corners of cells that lie in the open, and those that lie in or behind other geometry.
///
/// A floor that runs on under a wall has cells of which one corner is in the room and another in the wall. Their light
/// is that of the room, up to the wall: what a corner in the wall stands for is seen from one in the open. So it is with
/// corners just beyond a thin wall or floor, where what lies beyond is another room, or the sky.
#ifndef RSV_OPEN_CORNERS_H
#define RSV_OPEN_CORNERS_H

#include "cell_visibility.h"

#define RSV_CORNERS_OPEN 7u      ///< bit k: corner k of the cell lies in the open
#define RSV_CELL_CUT 8u          ///< something stands upon the cell, or between its corners
#define RSV_CELL_CUT_THROUGH 16u ///< what does keeps corners apart that lie in the open
/// All of the cell lies in a gap, such as behind a picture: its light is that of the gap, and its corners are open if they
/// see that.
#define RSV_CELL_SHELTERED 32u
/// No corner lies in the open, but the middle does: a plate whose border is set in a frame.
#define RSV_CELL_OPEN_INSIDE 64u
#define RSV_OPENNESS_KNOWN 128u ///< with the others, where that is not certain

/// Judges the corners of every cell, once: fills `cell_openness`. It depends on what lies around a cell and on the spacing alone, and on no random
/// numbers of nodes: neighbours agree, and edits elsewhere change nothing.
/// @param earlier elements of the same faces on which that was done: cells that are the same stay as they were; may be NULL
rsv_status rsv_elements_find_open_corners(const rsv_transport_scene *scene,
    const rsv_elements *earlier, rsv_elements *elements, uint64_t *rays);

/// Judges the corners of one cell again, whatever `cell_openness` has. @return what belongs there
uint8_t rsv_cell_judge_again(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t cell, uint64_t *rays);

/// The same for one cell, from `cell_openness` where that is filled.
uint8_t rsv_cell_openness(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t cell, const rsv_cell_shape *shape, uint64_t *rays);

/// A little above a place of the cell, and within the gap if it lies in one.
rsv_vec3 rsv_cell_above(uint8_t openness, const rsv_cell_shape *shape, rsv_vec3 place);

/// From where the cell is seen on behalf of a corner: from above that corner if it lies in the open, or else from above
/// another that does, or the middle. @return false if none does
bool rsv_cell_outlook(
    uint8_t openness, const rsv_cell_shape *shape, uint32_t corner, rsv_vec3 *place);

/// Whether a place of the cell is seen from that outlook, and nothing lies upon it.
bool rsv_cell_sees(const rsv_transport_scene *scene, uint8_t openness, const rsv_cell_shape *shape,
    rsv_vec3 outlook, rsv_vec3 place);

#endif
