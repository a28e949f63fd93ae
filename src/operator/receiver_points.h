/// The places on an element from which the rays of its row leave, and their aim.
#ifndef RSV_RECEIVER_POINTS_H
#define RSV_RECEIVER_POINTS_H

#include "../elements/elements.h"
#include "resolvent/trace.h"
#include "transport.h"

/// Points of one node side by side, one per lane of a packet, each with a frame about its shading normal. All frames of
/// a node are turned by the same random angle.
typedef struct rsv_receiver_points {
    float origin_x[RSV_SUPPORT_POINTS];
    float origin_y[RSV_SUPPORT_POINTS], origin_z[RSV_SUPPORT_POINTS];
    float tangent_x[RSV_SUPPORT_POINTS], tangent_y[RSV_SUPPORT_POINTS];
    float tangent_z[RSV_SUPPORT_POINTS];
    float bitangent_x[RSV_SUPPORT_POINTS], bitangent_y[RSV_SUPPORT_POINTS];
    float bitangent_z[RSV_SUPPORT_POINTS];
    float normal_x[RSV_SUPPORT_POINTS], normal_y[RSV_SUPPORT_POINTS], normal_z[RSV_SUPPORT_POINTS];
    float geometric_x[RSV_SUPPORT_POINTS], geometric_y[RSV_SUPPORT_POINTS];
    float geometric_z[RSV_SUPPORT_POINTS];
} __attribute__((aligned(64))) rsv_receiver_points;

/// Where the points lie. Points that are buried leave their lanes to the others.
/// @param index of the node whose random numbers are used: `node`, or what it was in an earlier version of the scene
/// @param valid bit k = point k counts; not 0
void rsv_receiver_points_choose(const rsv_elements *elements, uint32_t node, uint32_t index,
    uint32_t seed, uint16_t valid, rsv_support_point sample[RSV_SUPPORT_POINTS]);

/// @param sample from rsv_receiver_points_choose with the same index and seed
void rsv_receiver_points_set_up(const rsv_elements *elements,
    const rsv_support_point sample[RSV_SUPPORT_POINTS], uint32_t index, uint32_t seed,
    rsv_receiver_points *points);

/// Aims one ray per lane along (x, y, z) in the lane's frame. Rays that an interpolated normal sends below the surface start
/// dead, but count: they carry nothing.
void rsv_receiver_points_aim(const rsv_receiver_points *points, const float *x, const float *y,
    const float *z, rsv_ray_packet *packet);

#endif
