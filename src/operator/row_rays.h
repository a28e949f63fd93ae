/// The rays of a row of G and where they end, for device code too.
#ifndef RSV_ROW_RAYS_H
#define RSV_ROW_RAYS_H

#include "../surface/entry.h"
#include "../surface/medium.h"
#include "receiver_points.h"

typedef enum rsv_target_kind {
    RSV_TARGET_BLACK,
    RSV_TARGET_LAMBERT,
    RSV_TARGET_SPECULAR,
    RSV_TARGET_SKY,
    RSV_TARGET_ENTERED ///< of rays alone: they ended in the first surface they met, though another path might not have
} rsv_target_kind;

/// One side of a triangle as the end of a ray, in eight bytes: all that most ends need.
typedef struct rsv_ray_target {
    uint32_t face;
    uint16_t side; ///< cells along an edge of the face's grid
    uint8_t kind;
} rsv_ray_target;

/// The receiver points of one node, and data of the node as a whole.
typedef struct rsv_row_receiver {
    rsv_receiver_points points;
    rsv_surface_entry entry;
    rsv_rgb
        entry_scale; ///< makes the mean of the entry over the rays 1, which it is over all angles
    rsv_medium medium;
    uint32_t index; ///< of the node, or of the one whose random numbers are used
    uint16_t valid; ///< bit k = point k counts
    bool in_air;    ///< a voxel, which takes light from all sides as it is; it has no points
    bool tints;     ///< light from plain surfaces is tinted too, by a coat or medium
} rsv_row_receiver;

/// Ends of a row's rays that have been traced elsewhere.
typedef struct rsv_row_ends {
    const uint32_t
        *column; ///< [rays] the node from which light arrives; RSV_NONE = none, or not finished
    const uint32_t *left; ///< [left_count] rays to follow further, ascending
    const rsv_hit *hit;   ///< [left_count] hits of these; triangle RSV_NONE = the sky
    size_t left_count;
} rsv_row_ends;

#endif
