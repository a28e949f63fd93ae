/// Data of a tracked row besides its rays: entries with colours, escapes, emission and corners of paths, each with its
/// ray.
#ifndef RSV_TRACKED_ROW_H
#define RSV_TRACKED_ROW_H

#include "../update/row_record.h"
#include "row_track.h"

/// In one piece of memory, which grows.
typedef struct rsv_row_tail {
    uint32_t tinted_count, bin_count, tinted_bin_count, light_count, color_count, trail_count;
    uint32_t capacity; ///< bytes of the following data
} rsv_row_tail;

/// Where its arrays lie.
typedef struct rsv_row_tail_view {
    rsv_rgb *tinted_weight, *bin_weight;
    rsv_rgb *color; ///< [color_count] of emission: most rays that meet a lamp find the same
    uint32_t *tinted_column;
    rsv_trail_point *trail;
    uint16_t *tinted_ray, *bin, *bin_ray, *tinted_bin, *tinted_bin_ray, *light_ray, *light_color;
} rsv_row_tail_view;

/// @param t NULL = empty
RSV_INLINE rsv_row_tail_view rsv_row_tail_view_of(const rsv_row_tail *t)
{
    rsv_row_tail_view v = { 0 };
    if (!t) return v;
    v.tinted_weight = (rsv_rgb *)(void *)((uint8_t *)(uintptr_t)t + sizeof *t);
    v.bin_weight = v.tinted_weight + t->tinted_count;
    v.color = v.bin_weight + t->tinted_bin_count;
    v.tinted_column = (uint32_t *)(void *)(v.color + t->color_count);
    v.trail = (rsv_trail_point *)(void *)(v.tinted_column + t->tinted_count);
    v.tinted_ray = (uint16_t *)(void *)(v.trail + t->trail_count);
    v.bin = v.tinted_ray + t->tinted_count;
    v.bin_ray = v.bin + t->bin_count;
    v.tinted_bin = v.bin_ray + t->bin_count;
    v.tinted_bin_ray = v.tinted_bin + t->tinted_bin_count;
    v.light_ray = v.tinted_bin_ray + t->tinted_bin_count;
    v.light_color = v.light_ray + t->light_count;
    return v;
}

/// Stores the tracked data of a row. @param tail in and out
rsv_status rsv_row_tail_store(
    rsv_context *context, const rsv_row_scratch *scratch, rsv_row_tail **tail);

/// Copies the data of rays that are not affected to an empty row. @param touched [rays] one bit per ray
void rsv_row_tail_keep(const rsv_row_tail *tail, const uint64_t *touched, rsv_row_scratch *scratch);

/// Marks rays whose paths touch a box. @param touched [rays] bit by bit, added to
void rsv_row_tail_touch(const rsv_row_tail *tail, const rsv_trail_frame *frame,
    const rsv_scene_change *change, uint64_t *touched);

static inline bool rsv_ray_is_marked(const uint64_t *mark, uint32_t ray)
{
    return mark[ray / 64] >> (ray % 64) & 1;
}

#endif
