#include "node_rays.h"

#include "../core/parallel.h"

#include <string.h>

#define BLOCK 64 ///< nodes that a thread takes at a time

void rsv_block_escapes_add(
    rsv_context *context, rsv_block_escapes *block, const rsv_node_escape *escape)
{
    if (block->status != RSV_OK) return;
    block->status = rsv_grow(context, (void **)&block->escape, &block->capacity, block->count + 1,
        sizeof *block->escape);
    if (block->status == RSV_OK) block->escape[block->count++] = *escape;
}

static rsv_status collect(
    rsv_context *context, rsv_block_escapes *block, size_t block_count, rsv_node_escapes *escapes)
{
    size_t total = 0;
    for (size_t b = 0; b < block_count; b++) {
        if (block[b].status != RSV_OK) return block[b].status;
        total += block[b].count;
    }
    escapes->escape = rsv_reserve(context, total, sizeof *escapes->escape);
    if (!escapes->escape) return RSV_ERROR_MEMORY;
    for (size_t b = 0; b < block_count; b++) {
        if (block[b].count)
            memcpy(escapes->escape + escapes->count, block[b].escape,
                block[b].count * sizeof *escapes->escape);
        escapes->count += block[b].count;
    }
    return RSV_OK;
}

/// All blocks of nodes.
typedef struct escape_job {
    rsv_node_job nodes;
    rsv_block_escapes *block; ///< [block_count]
    size_t block_count;
    atomic_size_t done;
} escape_job;

static void trace_blocks(void *data, rsv_span span)
{
    escape_job *job = data;
    rsv_context *context = job->nodes.daylight->context;
    size_t nodes = job->nodes.op->elements->node_count;
    for (size_t b = span.begin; b < span.end; b++) {
        if (rsv_cancelled(context)) continue;
        size_t end = (b + 1) * BLOCK < nodes ? (b + 1) * BLOCK : nodes;
        rsv_node_rays_trace(&job->nodes, b * BLOCK, end, &job->block[b]);
        rsv_item_done(context, "sky", span.worker, &job->done, job->block_count);
    }
}

rsv_status rsv_node_escapes_find(const rsv_daylight *d, rsv_node_escapes *escapes)
{
    const rsv_operator_view *op = rsv_operator_get_view(d->light->op);
    uint32_t per_group = d->desc.node_rays / (RSV_NODE_PACKET * RSV_DAYLIGHT_GROUPS);
    size_t block_count = (op->elements->node_count + BLOCK - 1) / BLOCK;
    rsv_status status;
    *escapes = (rsv_node_escapes){ 0 };
    rsv_block_escapes *block = rsv_alloc(d->context, block_count, sizeof *block);
    if (!block) return RSV_ERROR_MEMORY;
    escape_job job = { { d, op, per_group > 1 ? per_group : 1 }, block, block_count, 0 };
    rsv_parallel_for(d->context, block_count, 1, trace_blocks, &job);
    RSV_TRY(rsv_progress(d->context, "sky", 1));
    RSV_TRY(collect(d->context, block, block_count, escapes));
cleanup:
    for (size_t b = 0; b < block_count; b++)
        rsv_free(d->context, block[b].escape);
    rsv_free(d->context, block);
    return status;
}

void rsv_node_escapes_free(rsv_context *context, rsv_node_escapes *escapes)
{
    rsv_free(context, escapes->escape);
    *escapes = (rsv_node_escapes){ 0 };
}
