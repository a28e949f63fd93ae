/// Restores elements from files: faces are found again in the scene, cells follow from the splits.
#ifndef RSV_ELEMENT_RESTORE_H
#define RSV_ELEMENT_RESTORE_H

#include "elements.h"

/// Elements with faces only.
/// @param alike elements of the same scene, whose faces are copied; NULL = find them in the scene
rsv_status rsv_elements_create_bare(const rsv_scene *scene, const rsv_bsdf *bsdf, float spacing,
    const rsv_elements *alike, rsv_elements **elements);

/// Whether each slot is split: [slot_count], 0 or 1. @return NULL if out of memory; freed by the caller
uint8_t *rsv_elements_splits(const rsv_elements *elements);

/// Fills slots and cells from face_level and splits. RSV_ERROR_FORMAT if they do not fit each other.
rsv_status rsv_elements_restore_cells(
    rsv_elements *elements, const uint8_t *split, size_t slot_count);

/// Checks cell_node, supports, hanging nodes and areas of elements whose arrays have the right lengths, and fills
/// node_hanging. RSV_ERROR_FORMAT for inconsistent data: indices out of range, nodes without cells, cycles of hanging
/// nodes.
rsv_status rsv_elements_restore_nodes(rsv_elements *elements);

/// Numbers of the cells that walls cut: [cut_count]. @return NULL if out of memory; freed by the caller
uint32_t *rsv_elements_cut_cells(const rsv_elements *elements);

/// Fills cell_cut. RSV_ERROR_FORMAT unless cells exist and ascend. @param cell [cut_count], those of cut_side
rsv_status rsv_elements_restore_cuts(rsv_elements *elements, const uint32_t *cell);

#endif
