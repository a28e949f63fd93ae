/// Receiver points that lie inside other geometry: under what stands on a floor, inside a wall.
#ifndef RSV_BURIAL_H
#define RSV_BURIAL_H

#include "../specular/specular_path.h"
#include "elements.h"

/// Receiver points that are drawn on the supports of nodes, as by rsv_elements_sample_support.
typedef struct rsv_support_draw {
    uint32_t points; ///< per node, at most 16
    uint32_t seed;
} rsv_support_draw;

/// Judges the receiver points of every free node. A point counts if it is seen from its node, or, where that is buried,
/// from another corner of the point's cell that lies in the open (open_corners.h), and if nothing lies right upon it:
/// otherwise it is inside other geometry, or on the far side of a wall. So a node in a wall stands for the surface up to
/// that wall.
/// @param known [node_count] non-zero = valid_points of this node stand already; NULL = none
/// @param valid_points [node_count], out: bit k = point k counts; 0 = all around the node is buried (or it hangs)
rsv_status rsv_find_buried(const rsv_transport_scene *scene, const rsv_elements *elements,
    rsv_support_draw draw, const uint8_t *known, uint16_t *valid_points, uint64_t *rays);

/// The points of one node, bit by bit, with the random numbers of the node of another index.
uint16_t rsv_judge_points(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t node, uint32_t index, rsv_support_draw draw, uint64_t *rays);

/// Lets every cell do without its buried corners: they take the value of a corner of the same cell that
/// is not buried, so that light does not fade to black where something stands on a surface, and does not
/// pass through what stands there either.
rsv_status rsv_elements_bridge_buried(rsv_elements *elements, const uint16_t *valid_points);

/// Marks nodes that say nothing, buried ones and those that hang on them, by an infinite deviation, so that
/// rsv_find_curved_edges does not take their zero for a shadow. @param deviation [node_count], others are kept
void rsv_mark_buried(const rsv_elements *elements, const uint16_t *valid_points, float *deviation);

#endif
