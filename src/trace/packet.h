/// Rays put side by side.
#ifndef RSV_PACKET_H
#define RSV_PACKET_H

#include "../core/vec.h"
#include "resolvent/trace.h"

/// Puts a ray into a lane; what the packet knows of hits stays as it is.
RSV_INLINE void rsv_packet_set_ray(rsv_ray_packet *packet, uint32_t lane, rsv_ray ray)
{
    packet->origin_x[lane] = ray.origin.x;
    packet->origin_y[lane] = ray.origin.y;
    packet->origin_z[lane] = ray.origin.z;
    packet->direction_x[lane] = ray.direction.x;
    packet->direction_y[lane] = ray.direction.y;
    packet->direction_z[lane] = ray.direction.z;
    packet->t_max[lane] = ray.t_max;
}

#endif
