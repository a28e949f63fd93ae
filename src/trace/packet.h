/// Rays put side by side.
#ifndef RSV_PACKET_H
#define RSV_PACKET_H

#include "../core/vec.h"
#include "../scene/twins.h"
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

/// See rsv_twins_settle. @param scene with twins
RSV_INLINE void rsv_packet_settle(const rsv_scene_view *scene, rsv_ray_packet *packet)
{
    for (int k = 0; k < 16; k++) {
        uint32_t met = packet->triangle[k];
        if (met == RSV_NONE || !scene->twins->flags[met]) continue;
        rsv_hit hit = { met, packet->t_max[k], packet->u[k], packet->v[k] };
        rsv_twins_settle(scene,
            v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]), &hit);
        if (hit.triangle == met) continue;
        rsv_vec3 normal = rsv_twin_plane_of(scene, hit.triangle).normal;
        packet->normal_x[k] = normal.x;
        packet->normal_y[k] = normal.y;
        packet->normal_z[k] = normal.z;
        packet->triangle[k] = hit.triangle;
        packet->u[k] = hit.u;
        packet->v[k] = hit.v;
    }
}

#endif
