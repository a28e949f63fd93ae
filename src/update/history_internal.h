/// Shared by the parts of history.c.
#ifndef RSV_HISTORY_INTERNAL_H
#define RSV_HISTORY_INTERNAL_H

#include "history_file.h"
#include "light_shafts.h"
#include "update_constants.h"

struct rsv_history {
    rsv_context *context;
    rsv_known_cells known_cells;
    rsv_store *store; ///< where it lies
    rsv_blob blob;
    const rsv_history_header *header; ///< of the blob
    rsv_history_layout layout;
    uint32_t
        *face_before[2]; ///< [triangle_count of the scene] by side: the same face; RSV_NONE = none
    rsv_scene_change added, change; ///< new objects; new and removed objects
    rsv_light_shafts shafts;        ///< through `change`
};

/// Whether every face has a grid, and slots form trees below it. @param taken [slot_count], zeros
bool rsv_history_cells_are_sound(const rsv_history_cells *cells, uint8_t *taken);
/// Answers for elements, from the history.
rsv_known_cells rsv_history_answers(const rsv_history *history);
/// Finds the faces of the scene again.
rsv_status rsv_history_find_faces(rsv_history *history, const rsv_scene_view *scene);

/// Whether something new or removed may affect the results of a cell.
bool rsv_history_is_beside(const rsv_history *history, const rsv_elements *elements, uint32_t cell);

#endif
