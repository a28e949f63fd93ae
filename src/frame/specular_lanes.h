/// Camera specular paths of sixteen rays, side by side.
#ifndef RSV_SPECULAR_LANES_H
#define RSV_SPECULAR_LANES_H

#include "../core/vec.h"
#include "resolvent/trace.h"

#define RSV_LANES RSV_PACKET_WIDTH

/// Colours or vectors, a row for each component.
typedef float rsv_lanes3[3][RSV_LANES];

/// The specular paths of a packet's rays. Fields without a comment are as in rsv_specular_path.
typedef struct rsv_specular_lanes {
    rsv_lanes3 weight;
    float start_ior[RSV_LANES], width[RSV_LANES];
    uint32_t trail[RSV_LANES]; ///< as in camera_path.h
    uint32_t pixel[RSV_LANES];
    uint32_t events[RSV_LANES]; ///< once they have arrived
    int medium[RSV_LANES];      ///< of rsv_specular_media
    int settled[RSV_LANES];
    // once they have arrived (rsv_specular_media_arrive)
    int back[RSV_LANES];
    uint32_t material[RSV_LANES]; ///< of the surface
    rsv_lanes3 throughput;
} __attribute__((aligned(64))) rsv_specular_lanes;

/// Ideal branches that leave their surfaces.
typedef struct rsv_branch_lanes {
    rsv_lanes3 origin, direction, weight; ///< of the specular path that sets out
    float t_min[RSV_LANES];               ///< nearer, their rays meet nothing
    uint32_t trail[RSV_LANES];
    int kind[RSV_LANES];  ///< rsv_branch_kind
    int alive[RSV_LANES]; ///< must be followed
} __attribute__((aligned(64))) rsv_branch_lanes;

#define RSV_BRANCH_KINDS 32

/// Branches from the same part of a picture behave similarly if they are of one kind: reflected or transmitted, from
/// the same side of a surface, into the same octant.
RSV_INLINE int rsv_branch_kind(bool back, bool transmit, rsv_vec3 direction)
{
    int octant = (direction.x < 0 ? 1 : 0) + (direction.y < 0 ? 2 : 0) + (direction.z < 0 ? 4 : 0);
    return octant + (transmit ? 8 : 0) + (back ? 16 : 0);
}

RSV_INLINE rsv_vec3 rsv_lane_vector(const rsv_lanes3 v, uint32_t lane)
{
    return v3(v[0][lane], v[1][lane], v[2][lane]);
}

RSV_INLINE rsv_rgb rsv_lane_color(const rsv_lanes3 v, uint32_t lane)
{
    return rgb(v[0][lane], v[1][lane], v[2][lane]);
}

RSV_INLINE void rsv_set_lane_vector(rsv_lanes3 v, uint32_t lane, rsv_vec3 a)
{
    v[0][lane] = a.x, v[1][lane] = a.y, v[2][lane] = a.z;
}

RSV_INLINE void rsv_set_lane_color(rsv_lanes3 v, uint32_t lane, rsv_rgb a)
{
    v[0][lane] = a.r, v[1][lane] = a.g, v[2][lane] = a.b;
}

#endif
