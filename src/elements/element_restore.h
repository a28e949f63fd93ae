/// Elements from what files keep of them: faces come from the scene again, cells from how often each was split.
#ifndef RSV_ELEMENT_RESTORE_H
#define RSV_ELEMENT_RESTORE_H

#include "elements.h"

/// Elements with faces alone.
/// @param alike elements of the same scene, whose faces are copied; NULL = faces are found anew
rsv_status rsv_elements_create_bare(const rsv_scene *scene, const rsv_bsdf *bsdf, float spacing,
    const rsv_elements *alike, rsv_elements **elements);

/// Whether each slot is split: [slot_count], 0 or 1. @return NULL on exhaustion; to be freed by the caller
uint8_t *rsv_elements_splits(const rsv_elements *elements);

/// Fills slots and cells from face_level and splits. RSV_ERROR_FORMAT if they do not fit each other.
rsv_status rsv_elements_restore_cells(
    rsv_elements *elements, const uint8_t *split, size_t slot_count);

/// Checks cell_node, supports, hanging nodes and areas of elements whose arrays have their proper lengths, and fills
/// node_hanging. RSV_ERROR_FORMAT for what would lead astray: indices past the end, nodes without cells, specular paths of
/// hanging nodes without an end.
rsv_status rsv_elements_restore_nodes(rsv_elements *elements);

#endif
