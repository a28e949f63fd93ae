/// The places on an element from which the rays of its row leave, and their aim.
#ifndef RSV_RECEIVER_POINTS_H
#define RSV_RECEIVER_POINTS_H

#include "../elements/elements.h"
#include "../surface/lift.h"
#include "resolvent/trace.h"
#include "transport.h"

/// Points of one node side by side, one per lane of a packet, each with a frame about its shading normal. The
/// first is turned by a random angle, the others follow it.
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
    float horizon_x[RSV_SUPPORT_POINTS], horizon_y[RSV_SUPPORT_POINTS];
    float horizon_z[RSV_SUPPORT_POINTS];
    float lift_x[RSV_SUPPORT_POINTS], lift_y[RSV_SUPPORT_POINTS], lift_z[RSV_SUPPORT_POINTS];
    uint32_t lifted; ///< lanes whose rays may leave another surface than their triangle (lift.h)
} __attribute__((aligned(64))) rsv_receiver_points;

/// Which points of which node.
typedef struct rsv_receiver_draw {
    uint32_t node;
    uint32_t
        index; ///< selects the random numbers: the node's, or its index in an earlier version of the scene
    uint32_t seed;
    uint16_t valid; ///< bit k = point k counts; not 0
} rsv_receiver_draw;

/// Where the points lie. Points that are buried leave their lanes to the others.
void rsv_receiver_points_choose(const rsv_elements *elements, rsv_receiver_draw draw,
    rsv_support_point sample[RSV_SUPPORT_POINTS]);

/// @param sample from rsv_receiver_points_choose with the same draw
void rsv_receiver_points_set_up(const rsv_elements *elements, const rsv_tracer *tracer,
    rsv_receiver_draw draw, const rsv_support_point sample[RSV_SUPPORT_POINTS],
    rsv_receiver_points *points);

/// The ray of a lane that may leave another surface than its triangle (bit k of `lifted`). @return false = it carries
/// nothing
RSV_INLINE bool rsv_receiver_points_lift(
    const rsv_receiver_points *p, uint32_t k, rsv_vec3 direction, rsv_ray *ray)
{
    rsv_surface_point point = { .geometric = { 0 } };
    point.geometric = v3(p->geometric_x[k], p->geometric_y[k], p->geometric_z[k]);
    point.lift = v3(p->lift_x[k], p->lift_y[k], p->lift_z[k]);
    rsv_vec3 horizon = v3(p->horizon_x[k], p->horizon_y[k], p->horizon_z[k]);
    ray->origin =
        rsv_lifted_origin(&point, v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]), direction);
    ray->direction = direction;
    ray->t_max = INFINITY;
    return v3_dot(direction, horizon) > 0;
}

/// Aims one ray per lane along (x, y, z) in the lane's frame. Rays that an interpolated normal sends below the surface
/// start dead, but count: they carry nothing.
void rsv_receiver_points_aim(const rsv_receiver_points *points, const float *x, const float *y,
    const float *z, rsv_ray_packet *packet);

#endif
