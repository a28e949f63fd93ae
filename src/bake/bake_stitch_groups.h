/// Groups of stitches that share no texels, so that each group can be solved separately.
#ifndef RSV_BAKE_STITCH_GROUPS_H
#define RSV_BAKE_STITCH_GROUPS_H

#include "bake_stitch.h"

/// Stitches of different groups share no texel.
typedef struct rsv_bake_stitch_groups {
    rsv_bake_stitch *stitch; ///< [stitch_count] group by group
    size_t stitch_count, count;
    size_t *first_stitch;  ///< [count + 1]
    uint32_t *first_texel; ///< [count + 1] for numbering the texels group by group
} rsv_bake_stitch_groups;

/// Destroy it even after an error.
rsv_status rsv_bake_stitch_groups_create(rsv_context *context, const rsv_bake_map *map,
    const rsv_bake_stitch *stitch, size_t count, rsv_bake_stitch_groups *groups);
void rsv_bake_stitch_groups_destroy(rsv_context *context, rsv_bake_stitch_groups *groups);

#endif
