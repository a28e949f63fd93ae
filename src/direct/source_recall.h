/// Direct light from before the scene was edited: where it may be another now, and what is taken over elsewhere.
#ifndef RSV_SOURCE_RECALL_H
#define RSV_SOURCE_RECALL_H

#include "../elements/past.h"

typedef struct rsv_source_recall {
    const rsv_past *past;
    const rsv_elements *coarse;
    uint8_t *lit_anew; ///< [cell_count of `coarse`] non-zero = light may be another
    uint8_t *anew;     ///< likewise, and cells beside those: their splits are found again
    size_t most_cells; ///< after splits
} rsv_source_recall;

/// Fields of one level. All [node_count].
typedef struct rsv_recalled_fields {
    rsv_rgb *direct;
    float *deviation;
    uint16_t *valid_points;
    uint8_t *known; ///< 1 where valid_points are known
    uint8_t *lit;   ///< 1 where direct and deviation are
} rsv_recalled_fields;

/// @param coarse elements that the level starts from
rsv_status rsv_source_recall_create(
    const rsv_past *past, const rsv_elements *coarse, rsv_source_recall **recall);
void rsv_source_recall_destroy(rsv_source_recall *recall);

/// Whether splits of a cell are to be found again. @param cell of finer elements
bool rsv_source_recall_is_anew(const rsv_source_recall *recall, const rsv_cell *cell);

/// Splits cells as they were split then, where light is the same.
/// @param most_cells no round of splits leads to more than about so many
rsv_status rsv_source_recall_splits(rsv_source_recall *recall, size_t most_cells,
    const rsv_elements *elements, rsv_elements **finer);

/// Fills in what is known of free nodes, of this level or of the coarse one; leaves the others as they are.
rsv_status rsv_source_recall_nodes(const rsv_source_recall *recall, const rsv_elements *elements,
    const rsv_recalled_fields *fields);

#endif
