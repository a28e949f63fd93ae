/// Reuses coarse elements from before an edit, away from the change.
#ifndef RSV_KEPT_ELEMENTS_H
#define RSV_KEPT_ELEMENTS_H

#include "history.h"

/// Splits cells and shrinks clusters as before, except near the change. Replaces `*elements`.
rsv_status rsv_kept_splits(const rsv_history *history, const rsv_transport_scene *scene,
    rsv_elements **elements, uint64_t *rays);

/// Has points of nodes that were there then drawn as they were then (node_draw): those around which nothing changed
/// need not be judged. @param valid_points, known [node_count] out
rsv_status rsv_kept_points(
    const rsv_history *history, rsv_elements *elements, uint16_t *valid_points, uint8_t *known);

#endif
