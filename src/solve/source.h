/// E0: light that arrives from the sources, on the coarse elements and on finer levels.
#ifndef RSV_SOURCE_H
#define RSV_SOURCE_H

#include "light_internal.h"

/// Cells in which elements of the levels would be wasted.
typedef struct rsv_level_limits {
    size_t max_cells; ///< no more splits that lead beyond, level by level
    const uint8_t *
        hidden; ///< [cell_count of the coarse elements] non-zero = not worth splitting; NULL = all are
} rsv_level_limits;

/// Cells of the coarse elements that the goal of a light does not see. @param hidden out: freed by the caller; NULL =
/// no goal
rsv_status rsv_source_hidden_cells(const rsv_light *light, uint8_t **hidden);

/// Direct light and caustics on finer elements, where they are requested. Caustics have separate elements, which do not
/// depend on whether direct light is left to the renderer.
rsv_status rsv_source_create_levels(rsv_light *light, const rsv_level_limits *limits);

/// Updates both levels to the present positions of surfaces, in place.
/// @param motion NULL = build everything again
/// @param caustics motion since caustics were updated; NULL = leave them as they are
rsv_status rsv_source_follow_levels(rsv_light *light, const rsv_level_limits *limits,
    const rsv_level_motion *motion, const rsv_level_motion *caustics);

/// Whether the level of direct light has many splits of earlier motions, and should be divided again.
bool rsv_source_has_grown(const rsv_light *light);
/// Builds the level of direct light again, reusing what is still valid where nothing moved; updates caustics too.
/// @param motion,caustics as for rsv_source_follow_levels; `motion` not NULL
rsv_status rsv_source_divide_again(rsv_light *light, const rsv_level_limits *limits,
    const rsv_level_motion *motion, const rsv_level_motion *caustics);

/// A level of the light with more splits where its present sources require them; its fields are only for splitting.
rsv_status rsv_source_refine_level(
    rsv_light *light, const rsv_level_limits *limits, bool caustic, rsv_source_level *finer);

/// Direct light only, of all nodes that are not known. @param known [node_count]
rsv_status rsv_source_estimate(rsv_light *light, const uint8_t *known);

/// E0 on the coarse elements: next-event estimates, gathered emission and caustics. Needs rows.
rsv_status rsv_source_create(rsv_light *light);

/// Adds gathered light and caustics to the next-event estimates in `source`.
void rsv_source_complete(rsv_light *light);

/// Adds gathered emission, by rows and by the bins of the surroundings as they are now, and caustics to `source`.
void rsv_source_add_gathered(rsv_light *light);

#endif
