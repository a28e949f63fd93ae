/// Receiver points inside other geometry: under an object on a floor, inside a wall.
#ifndef RSV_BURIAL_H
#define RSV_BURIAL_H

#include "../specular/specular_path.h"
#include "elements.h"

/// Receiver points that are drawn on the supports of nodes, as by rsv_elements_sample_support.
typedef struct rsv_support_draw {
    uint32_t points; ///< per node, at most 16
    uint32_t seed;
} rsv_support_draw;

/// Tests the receiver points of every free node. A point is valid if it is visible from its node or, if that is buried,
/// from another corner of the point's cell in the open (open_corners.h), and nothing touches it. Otherwise it is inside
/// other geometry, or on the far side of a wall. A node inside a wall therefore represents the surface up to that wall.
/// @param known [node_count] non-zero = valid_points of this node are known; NULL = none are
/// @param valid_points [node_count], out: bit k = point k is valid; 0 = the node is buried entirely (or it hangs)
rsv_status rsv_find_buried(const rsv_transport_scene *scene, const rsv_elements *elements,
    rsv_support_draw draw, const uint8_t *known, uint16_t *valid_points, uint64_t *rays);

/// The points of one node, bit by bit, with the random numbers of the node of another index.
uint16_t rsv_judge_points(const rsv_transport_scene *scene, const rsv_elements *elements,
    uint32_t node, uint32_t index, rsv_support_draw draw, uint64_t *rays);

/// Replaces buried corners of every cell: they take the value of a corner of the same cell that is not buried. Light
/// then does not fade to black under objects on a surface, and does not leak through them either.
rsv_status rsv_elements_bridge_buried(rsv_elements *elements, const uint16_t *valid_points);

/// Marks nodes that say nothing, buried ones and those that hang on them, by an infinite deviation, so that
/// rsv_find_curved_edges does not take their zero for a shadow. @param deviation [node_count], others are kept
void rsv_mark_buried(const rsv_elements *elements, const uint16_t *valid_points, float *deviation);

#endif
