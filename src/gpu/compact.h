/// Lists of set flags on the device.
#ifndef RSV_GPU_COMPACT_H
#define RSV_GPU_COMPACT_H

#include "gpu.h"

/// Scratch memory for a number of flags.
typedef struct rsv_compactor {
    uint32_t *group, *chunk, *begin;
} rsv_compactor;

/// Part of a layout (gpu.h).
void rsv_compactor_place(rsv_compactor *compactor, rsv_gpu_block *block, size_t most);

/// Lists the indices of set flags in ascending order, and waits for the result.
/// @param flag [count] 0 or 1 @param list large enough for all set flags @return number of set flags; 0 after a failure
uint32_t rsv_compact(rsv_gpu *gpu, const rsv_compactor *compactor, const uint8_t *flag,
    size_t count, uint32_t *list);

#endif
