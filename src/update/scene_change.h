/// What an edit of the scene put where it was not before: all that rays which used to pass may now meet.
///
/// Triangles are known again by where they are, whatever object they belong to. What an edit took away needs no mention
/// where rays that met it ended on it, at nodes that are no more.
#ifndef RSV_SCENE_CHANGE_H
#define RSV_SCENE_CHANGE_H

#include "../core/core.h"
#include "resolvent/trace.h"

#define RSV_MOST_CHANGES 16

typedef struct rsv_scene_change {
    rsv_vec3 low[RSV_MOST_CHANGES], high[RSV_MOST_CHANGES]; ///< boxes around what is new
    uint32_t count;
    bool has_gone; ///< there are boxes around what is gone, too
} rsv_scene_change;

/// Keys of the triangles that stop every ray, for a later version of the scene. Those with holes are left out: they count
/// as new in every version, as their holes may be others.
/// @param keys out: [*count], in ascending order, to be freed
rsv_status rsv_scene_change_keys(
    rsv_context *context, const rsv_scene_view *scene, uint64_t **keys, size_t *count);

/// @param keys [count] of the earlier version
rsv_scene_change rsv_scene_change_since(
    const rsv_scene_view *scene, const uint64_t *keys, size_t count);

/// Adds a box. @param runs_on it belongs to the one added just before; else the two that waste least space by that become
/// one where there are too many
void rsv_scene_change_add(rsv_scene_change *change, rsv_vec3 low, rsv_vec3 high, bool runs_on);
/// Lets the box that grows least by it cover another one, which lies beside one of them.
void rsv_scene_change_cover(rsv_scene_change *change, rsv_vec3 low, rsv_vec3 high);
/// To be called once after all boxes were added: against rounding.
void rsv_scene_change_add_margins(rsv_scene_change *change);

/// Metres along each ray of a packet to where it first runs into a box. @param at out: INFINITY = it meets none
void rsv_scene_change_meets(
    const rsv_scene_change *change, const rsv_ray_packet *packet, float at[RSV_PACKET_WIDTH]);

#endif
