/// Corners of cells in the open, and corners inside or behind other geometry.
///
/// A floor that continues under a wall has cells with one corner in the room and another in the wall. Their light is
/// that of the room, up to the wall: visibility for a corner in the wall is tested from a corner in the open. The same
/// applies to corners just beyond a thin wall or floor, behind which is another room, or the sky.
#ifndef RSV_OPEN_CORNERS_H
#define RSV_OPEN_CORNERS_H

#include "cell_visibility.h"

#define RSV_CORNERS_OPEN 7u      ///< bit k: corner k of the cell lies in the open
#define RSV_CELL_CUT 8u          ///< something stands upon the cell, or between its corners
#define RSV_CELL_CUT_THROUGH 16u ///< what does keeps corners apart that lie in the open
/// All of the cell is in a gap, such as behind a picture: its light is that of the gap, and corners that see the gap
/// are open.
#define RSV_CELL_SHELTERED 32u
/// No corner is in the open, but the centre is: a plate whose border is inside a frame.
#define RSV_CELL_OPEN_INSIDE 64u
#define RSV_OPENNESS_KNOWN 128u ///< set with the others where their absence would be ambiguous

/// Finds the openness of the corners of every cell, once, and fills `cell_openness`. It depends only on the
/// surroundings of a cell and the spacing, not on random numbers of nodes, so neighbours agree, and edits elsewhere
/// change nothing.
/// @param earlier elements of the same faces with known openness: cells that are the same keep theirs; may be NULL
rsv_status rsv_elements_find_open_corners(const rsv_transport_scene *scene,
    const rsv_elements *earlier, rsv_elements *elements, uint64_t *rays);

/// Computes the openness of one cell again, ignoring `cell_openness`.
uint8_t rsv_cell_judge_again(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t cell, uint64_t *rays);

/// The openness of one cell, from `cell_openness` if that is filled.
uint8_t rsv_cell_openness(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t cell, const rsv_cell_shape *shape, uint64_t *rays);

/// A point slightly above a place of the cell, inside the gap if it is in one.
rsv_vec3 rsv_cell_above(uint8_t openness, const rsv_cell_shape *shape, rsv_vec3 place);

/// The point from which visibility is tested for a corner: above the corner if it is in the open, otherwise above
/// another open corner or the centre. @return false if there is none
bool rsv_cell_outlook(
    uint8_t openness, const rsv_cell_shape *shape, uint32_t corner, rsv_vec3 *place);

/// Whether a place of the cell is seen from that outlook, and nothing lies upon it.
bool rsv_cell_sees(const rsv_transport_scene *scene, uint8_t openness, const rsv_cell_shape *shape,
    rsv_vec3 outlook, rsv_vec3 place);

#endif
