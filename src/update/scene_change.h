/// The places where an edit added something, which rays that used to pass may now hit.
///
/// Triangles are recognised by position, whatever object they belong to. Removed ones need not be recorded if rays that
/// hit them ended there, at nodes that no longer exist.
#ifndef RSV_SCENE_CHANGE_H
#define RSV_SCENE_CHANGE_H

#include "../core/core.h"
#include "resolvent/trace.h"

#define RSV_MOST_CHANGES 16

typedef struct rsv_scene_change {
    rsv_vec3 low[RSV_MOST_CHANGES], high[RSV_MOST_CHANGES]; ///< boxes around new objects
    uint32_t count;
    bool has_gone; ///< includes boxes around removed objects
} rsv_scene_change;

/// Keys of the triangles that stop every ray, for a later version of the scene. Cut-out triangles are omitted. They
/// count as new in every version, because their holes may have changed.
/// @param keys out: [*count], ascending, freed by the caller
rsv_status rsv_scene_change_keys(
    rsv_context *context, const rsv_scene_view *scene, uint64_t **keys, size_t *count);

/// @param keys [count] of the earlier version
rsv_scene_change rsv_scene_change_since(
    const rsv_scene_view *scene, const uint64_t *keys, size_t count);

/// Adds a box. @param runs_on it belongs to the one added just before; else the two that waste least space by that
/// become one where there are too many
void rsv_scene_change_add(rsv_scene_change *change, rsv_vec3 low, rsv_vec3 high, bool runs_on);

/// Adds all boxes of another change.
void rsv_scene_change_add_all(rsv_scene_change *change, const rsv_scene_change *more);
/// Adds a box that is next to one of the boxes, by extending the one that grows least.
void rsv_scene_change_cover(rsv_scene_change *change, rsv_vec3 low, rsv_vec3 high);
/// Adds margins against rounding. Call it once, after all boxes have been added.
void rsv_scene_change_add_margins(rsv_scene_change *change);

/// Metres along each ray of a packet to where it first runs into a box. @param at out: INFINITY = it meets none
void rsv_scene_change_meets(
    const rsv_scene_change *change, const rsv_ray_packet *packet, float at[RSV_PACKET_WIDTH]);

#endif
