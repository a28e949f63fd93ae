/// Which rays of a row touch boxes in which something moved: rays are not kept, but made again from their numbers. Most
/// packets of sixteen are ruled out at once, as their directions lie in a narrow cone.
#ifndef RSV_ROW_TOUCH_H
#define RSV_ROW_TOUCH_H

#include "../update/scene_change.h"
#include "directions.h"
#include "receiver_points.h"

#define RSV_MOST_ROW_PACKETS 256

/// Where the rays of a row leave, all lanes together.
typedef struct rsv_row_place {
    rsv_vec3 centre, tangent, normal; ///< of the first lane's frame
    float radius;                     ///< metres, of a ball around all origins
    float spread; ///< radians by which the frames of lanes differ from that; beyond pi: anything
} rsv_row_place;

rsv_row_place rsv_row_place_of(const rsv_receiver_points *points);

/// Cones around the directions of each packet, in the frame of a row.
typedef struct rsv_row_cones {
    rsv_context *context;
    uint32_t packets;         ///< per set of directions
    float *x, *y, *z, *angle; ///< [RSV_DIRECTION_SETS * packets] axis, and radians from it
} rsv_row_cones;

rsv_status rsv_row_cones_create(
    rsv_context *context, const rsv_directions *directions, rsv_row_cones *cones);
void rsv_row_cones_destroy(rsv_row_cones *cones);

/// Marks the packets whose rays may meet a box. @param set of directions, as a number of its first cone
/// @param packet out: [(packets + 63) / 64] bit by bit @return whether there are any
bool rsv_row_cones_meet(const rsv_row_cones *cones, size_t set, const rsv_row_place *place,
    const rsv_scene_change *change, uint64_t *packet);

#endif
