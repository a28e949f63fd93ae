/// A level of direct light before a motion, in memory: results that a new level can reuse. Both levels start from the
/// same coarse elements, so cells are recognised by position.
#ifndef RSV_LEVEL_BEFORE_H
#define RSV_LEVEL_BEFORE_H

#include "../elements/known_cells.h"
#include "light_shafts.h"

/// All of it is borrowed.
typedef struct rsv_level_before {
    const rsv_elements *elements;
    const rsv_rgb *direct;        ///< [node_count] W/m2
    const float *deviation;       ///< [node_count] of its luminance
    const uint16_t *valid_points; ///< [node_count]
    const rsv_light_shafts *shafts;
    const uint8_t *moved; ///< [triangle_count] RSV_MOVE_... (moved_elements.h)
} rsv_level_before;

/// Answers for elements. @param before must not move
rsv_known_cells rsv_level_before_answers(const rsv_level_before *before);

/// Whether a cell was split.
bool rsv_level_before_was_split(
    const rsv_level_before *before, const rsv_elements *elements, uint32_t cell);

/// The same free node before, if nothing has moved next to it; otherwise RSV_NONE.
uint32_t rsv_level_before_find(
    const rsv_level_before *before, const rsv_elements *elements, uint32_t node);

#endif
