#include "compact.h"

#include "compact_kernels.h"

static size_t groups_of(size_t count) { return (count + RSV_GROUP_FLAGS - 1) / RSV_GROUP_FLAGS; }

static size_t chunks_of(size_t count)
{
    return (groups_of(count) + RSV_CHUNK_GROUPS - 1) / RSV_CHUNK_GROUPS;
}

void rsv_compactor_place(rsv_compactor *c, rsv_gpu_block *block, size_t most)
{
    c->group = rsv_gpu_place(block, groups_of(most), sizeof *c->group);
    c->chunk = rsv_gpu_place(block, chunks_of(most), sizeof *c->chunk);
    c->begin = rsv_gpu_place(block, chunks_of(most) + 1, sizeof *c->begin);
}

uint32_t rsv_compact(
    rsv_gpu *gpu, const rsv_compactor *c, const uint8_t *flag, size_t count, uint32_t *list)
{
    size_t groups = groups_of(count), chunks = chunks_of(count);
    const rsv_compact_args args = { flag, (uint32_t)count, (uint32_t)groups, c->group, c->chunk,
        c->begin, list };
    uint32_t total = 0;
    if (count == 0) return 0;
    rsv_launch_count_group(gpu, &args, groups);
    rsv_launch_count_chunk(gpu, &args, chunks);
    rsv_launch_begin_chunk(gpu, &args, chunks + 1);
    rsv_launch_list_group(gpu, &args, groups);
    rsv_gpu_download(gpu, &total, c->begin + chunks, sizeof total);
    return gpu->status == RSV_OK ? total : 0;
}
