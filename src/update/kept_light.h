/// Direct light from before an edit: where it may have changed, and reuse of the rest.
#ifndef RSV_KEPT_LIGHT_H
#define RSV_KEPT_LIGHT_H

#include "history.h"
#include "level_before.h"

typedef struct rsv_kept_light {
    const rsv_history *history;     ///< NULL = there is `before`
    const rsv_level_before *before; ///< the level itself; NULL = there is `history`
    const rsv_elements *coarse;
    uint8_t *light_changed; ///< [cell_count of `coarse`] non-zero = light may be another
    uint8_t *changed;       ///< the same, and neighbouring cells, whose splits are found again
    size_t most_cells;      ///< after splits
} rsv_kept_light;

/// Fields of one level. All [node_count].
typedef struct rsv_kept_light_fields {
    rsv_rgb *direct;
    float *deviation;
    uint16_t *valid_points;
    uint32_t points; ///< of a node, bits of valid_points
    uint8_t *known;  ///< 1 where valid_points are known
    uint8_t *lit;    ///< 1 where direct and deviation are
} rsv_kept_light_fields;

/// @param history, before one of them, the other NULL
/// @param coarse elements that the level starts from
rsv_status rsv_kept_light_create(const rsv_history *history, const rsv_level_before *before,
    const rsv_elements *coarse, rsv_kept_light **kept);
void rsv_kept_light_destroy(rsv_kept_light *kept);

/// Whether to find the splits of a cell again. @param cell of finer elements
bool rsv_kept_light_is_changed(const rsv_kept_light *kept, const rsv_cell *cell);

/// Splits cells as before where light is the same.
/// @param most_cells approximate limit of cells after each round of splits
rsv_status rsv_kept_light_splits(
    rsv_kept_light *kept, size_t most_cells, const rsv_elements *elements, rsv_elements **finer);

/// Fills in known light of free nodes of this level, or of the coarse one. Other nodes, and nodes that already have
/// light, are unchanged. @param kept out: number of free, not buried nodes with known light; may be NULL
rsv_status rsv_kept_light_nodes(const rsv_kept_light *light, const rsv_elements *elements,
    const rsv_kept_light_fields *fields, size_t *kept);

/// Fills in known direct light of free nodes of the coarse level. @param known [node_count], out
rsv_status rsv_kept_direct(
    const rsv_history *history, const rsv_elements *elements, rsv_rgb *direct, uint8_t *known);

#endif
