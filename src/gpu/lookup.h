/// Elements on the device, as far as it takes to find the cell of a place.
#ifndef RSV_GPU_LOOKUP_H
#define RSV_GPU_LOOKUP_H

#include "../elements/elements.h"
#include "gpu.h"

typedef struct rsv_gpu_lookup {
    const rsv_elements *host; ///< borrowed until it is uploaded
    rsv_elements
        elements; ///< device addresses: only face_level, face_slot, slot, cell_node, cell_cut, cut_side,
                  ///< face_of
    rsv_elements *there; ///< the same, on the device
} rsv_gpu_lookup;

/// Part of a task's layout. @param triangle_count of the scene
void rsv_gpu_lookup_place(rsv_gpu_lookup *lookup, size_t triangle_count, rsv_gpu_block *block);
void rsv_gpu_lookup_upload(const rsv_gpu_lookup *lookup, size_t triangle_count, rsv_gpu *gpu);

#endif
