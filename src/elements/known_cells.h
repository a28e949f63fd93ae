/// Results known from an earlier version of the scene (update/history.h). Elements use them instead of tracing rays, or
/// of decisions that depend on the whole scene.
#ifndef RSV_KNOWN_CELLS_H
#define RSV_KNOWN_CELLS_H

#include "elements.h"

/// Answers from any thread; false = it is not known, or may be another now.
typedef struct rsv_known_cells {
    const void *user;
    /// Level of the regular grid of a face.
    bool (*grid_level)(
        const void *user, const rsv_elements *elements, uint32_t face, uint8_t *level);
    /// Whether a cell is split where other geometry cuts it.
    bool (*is_split)(const void *user, const rsv_elements *elements, uint32_t cell, bool *split);
    /// As in cell_openness.
    bool (*openness)(
        const void *user, const rsv_elements *elements, uint32_t cell, uint8_t *openness);
    /// Marks nodes that no wall divides. @param undivided [node_count], zeros
    rsv_status (*find_undivided)(
        const void *user, const rsv_elements *elements, uint8_t *undivided);
} rsv_known_cells;

#endif
