/// The indices of set flags, in order: counts by group of flags, sums of counts by chunk of groups, and where that puts
/// each. Every step is the same on all devices, and so is the list.
#ifndef RSV_COMPACT_KERNELS_H
#define RSV_COMPACT_KERNELS_H

#include "launch.h"

#define RSV_GROUP_FLAGS 32u
#define RSV_CHUNK_GROUPS 32u

typedef struct rsv_compact_args {
    const uint8_t *flag; ///< [count] 0 or 1
    uint32_t count, group_count;
    uint32_t *group; ///< [group_count] set flags of each
    uint32_t *chunk; ///< [chunks] set flags of each
    uint32_t *begin; ///< [chunks + 1] set flags before each
    uint32_t *list;  ///< the indices
} rsv_compact_args;

RSV_INLINE uint32_t rsv_group_end(const rsv_compact_args *a, uint32_t group)
{
    uint32_t end = (group + 1) * RSV_GROUP_FLAGS;
    return end < a->count ? end : a->count;
}

RSV_INLINE void rsv_count_group_item(const rsv_compact_args *a, uint32_t group)
{
    uint32_t sum = 0;
    for (uint32_t k = group * RSV_GROUP_FLAGS; k < rsv_group_end(a, group); k++)
        sum += a->flag[k];
    a->group[group] = sum;
}

RSV_KERNEL(count_group, rsv_compact_args, rsv_count_group_item)

RSV_INLINE uint32_t rsv_count_add(uint32_t a, uint32_t b) { return a + b; }

RSV_INLINE uint32_t rsv_count_chunk_lane(const rsv_compact_args *a, uint32_t chunk, uint32_t lane)
{
    uint32_t sum = 0, end = (chunk + 1) * RSV_CHUNK_GROUPS;
    end = end < a->group_count ? end : a->group_count;
    for (uint32_t k = chunk * RSV_CHUNK_GROUPS + lane; k < end; k += RSV_LANES)
        sum += a->group[k];
    return sum;
}

RSV_INLINE void rsv_count_chunk_store(const rsv_compact_args *a, uint32_t chunk, uint32_t sum)
{
    a->chunk[chunk] = sum;
}

RSV_KERNEL_SUM(count_chunk, rsv_compact_args, uint32_t, rsv_count_chunk_lane, rsv_count_add,
    rsv_count_chunk_store)

RSV_INLINE uint32_t rsv_begin_chunk_lane(const rsv_compact_args *a, uint32_t chunk, uint32_t lane)
{
    uint32_t sum = 0;
    for (uint32_t k = lane; k < chunk; k += RSV_LANES)
        sum += a->chunk[k];
    return sum;
}

RSV_INLINE void rsv_begin_chunk_store(const rsv_compact_args *a, uint32_t chunk, uint32_t sum)
{
    a->begin[chunk] = sum;
}

RSV_KERNEL_SUM(begin_chunk, rsv_compact_args, uint32_t, rsv_begin_chunk_lane, rsv_count_add,
    rsv_begin_chunk_store)

RSV_INLINE void rsv_list_group_item(const rsv_compact_args *a, uint32_t group)
{
    uint32_t chunk = group / RSV_CHUNK_GROUPS, at = a->begin[chunk];
    for (uint32_t k = chunk * RSV_CHUNK_GROUPS; k < group; k++)
        at += a->group[k];
    for (uint32_t k = group * RSV_GROUP_FLAGS; k < rsv_group_end(a, group); k++)
        if (a->flag[k]) a->list[at++] = k;
}

RSV_KERNEL(list_group, rsv_compact_args, rsv_list_group_item)

#endif
