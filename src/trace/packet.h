/// Rays put side by side.
#ifndef RSV_PACKET_H
#define RSV_PACKET_H

#include "../core/vec.h"
#include "resolvent/trace.h"

/// Sets the ray of a lane; hits stay as they are.
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

/// Whether a ray ended at the back of a triangle.
RSV_INLINE bool rsv_packet_meets_back(const rsv_ray_packet *p, uint32_t lane)
{
    return p->normal_x[lane] * p->direction_x[lane] + p->normal_y[lane] * p->direction_y[lane] +
               p->normal_z[lane] * p->direction_z[lane] >
           0;
}

/// The hit of a traced ray.
RSV_INLINE rsv_hit rsv_packet_hit(const rsv_ray_packet *p, uint32_t lane)
{
    rsv_hit hit = { p->triangle[lane], p->t_max[lane], p->u[lane], p->v[lane] };
    return hit;
}

/// Where a ray ended.
RSV_INLINE rsv_vec3 rsv_packet_point(const rsv_ray_packet *p, uint32_t lane)
{
    rsv_vec3 origin = v3(p->origin_x[lane], p->origin_y[lane], p->origin_z[lane]);
    rsv_vec3 direction = v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
    return v3_mad(origin, p->t_max[lane], direction);
}

#endif
