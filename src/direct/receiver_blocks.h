/// Where the elements receive direct light, four neighbours to a packet of rays; kept while lights move.
#ifndef RSV_RECEIVER_BLOCKS_H
#define RSV_RECEIVER_BLOCKS_H

#include "../elements/burial.h"
#include "../sources/lights.h"
#include "../specular/specular_path.h"

#define RSV_BLOCK_NODES 4
#define RSV_BLOCK_POINTS 4 ///< of each node

/// Lane RSV_BLOCK_POINTS n + k is point k of the n-th node.
typedef struct rsv_receiver_block {
    float x[RSV_PACKET_WIDTH], y[RSV_PACKET_WIDTH], z[RSV_PACKET_WIDTH]; ///< off their surface
    float normal_x[RSV_PACKET_WIDTH], normal_y[RSV_PACKET_WIDTH], normal_z[RSV_PACKET_WIDTH];
    rsv_vec3 geometric[RSV_PACKET_WIDTH], lift[RSV_PACKET_WIDTH]; ///< of lanes that are lifted
    uint32_t lifted; ///< lanes whose rays may leave another surface than their triangle (lift.h)
    uint32_t node[RSV_BLOCK_NODES]; ///< RSV_NONE = none
    uint32_t valid;                 ///< lanes, a bit each
    bool coated;                    ///< some of them lose light at an interface as it enters
} __attribute__((aligned(64))) rsv_receiver_block;

/// Unoccluded and actual light of a node's rays.
typedef struct rsv_preview_sums {
    rsv_rgb open, visible;
} rsv_preview_sums;

typedef struct rsv_receiver_blocks {
    rsv_context *context;
    const rsv_transport_scene *scene;
    const rsv_elements *elements;
    rsv_receiver_block *block; ///< [block_count]
    size_t block_count;
    rsv_surface_entry *entry; ///< [block_count * RSV_BLOCK_NODES]; NULL = no material is coated
    uint8_t *held;            ///< [node_count] non-zero = in a block, or receives nothing
    bool holds_all;
    rsv_preview_sums *sums,
        *spread;           ///< [node_count] of the last preview, of nodes and of those around them
    _Atomic uint8_t *edge; ///< [node_count] non-zero = a shadow ended there or at a neighbour
} rsv_receiver_blocks;

/// @param scene, elements borrowed
/// @param draw, valid_points from rsv_find_buried: the first RSV_BLOCK_POINTS valid ones are used
/// @param moves [material_count] moving surfaces are in no block, nor are nodes inside absorbing bodies
rsv_status rsv_receiver_blocks_create(const rsv_transport_scene *scene,
    const rsv_elements *elements, rsv_support_draw draw, const uint16_t *valid_points,
    const bool *moves, rsv_receiver_blocks **blocks);
void rsv_receiver_blocks_destroy(rsv_receiver_blocks *blocks);

/// Gives rays that were aimed from a block's points their start; their ends stay.
void rsv_receiver_block_lift(const rsv_receiver_block *block, rsv_ray_packet *packet);

/// How light enters at a block's n-th node. @param block that is coated
RSV_INLINE const rsv_surface_entry *rsv_receiver_entry(
    const rsv_receiver_blocks *blocks, const rsv_receiver_block *block, uint32_t n)
{
    return &blocks->entry[(size_t)(block - blocks->block) * RSV_BLOCK_NODES + n];
}

#endif
