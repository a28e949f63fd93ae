#include "subsurface.h"

#include "../core/parallel.h"
#include "scatter_row.h"

#include <string.h>

#define ROWS_PER_BLOCK 64

/// The rows of a block, one after the other.
typedef struct row_block {
    uint32_t *column;
    rsv_rgb *weight;
    size_t count, column_capacity, weight_capacity;
} row_block;

static rsv_status store_row(rsv_context *context, const rsv_scatter_row *row, row_block *block)
{
    size_t needed = block->count + row->count;
    rsv_status status = rsv_grow(
        context, (void **)&block->column, &block->column_capacity, needed, sizeof *block->column);
    if (status == RSV_OK)
        status = rsv_grow(context, (void **)&block->weight, &block->weight_capacity, needed,
            sizeof *block->weight);
    if (status != RSV_OK) return status;
    for (uint32_t k = 0; k < row->count; k++) {
        block->column[block->count] = row->column[k];
        block->weight[block->count++] = row->weight[row->column[k]];
    }
    return RSV_OK;
}

static bool has_row(const rsv_scatter_sources *s, uint32_t node)
{
    return s->elements->node_hanging[node] == RSV_NONE && rsv_scatter_body_of(s, node) != RSV_NONE;
}

bool rsv_subsurface_has_row(const rsv_subsurface *p, uint32_t node)
{
    return has_row(p->sources, node);
}

static rsv_status gather_block(
    rsv_subsurface *p, size_t index, rsv_scatter_row *row, row_block *block)
{
    size_t begin = index * ROWS_PER_BLOCK, end = begin + ROWS_PER_BLOCK;
    if (end > p->row_count) end = p->row_count;
    for (size_t node = begin; node < end; node++) {
        if (!has_row(p->sources, (uint32_t)node)) continue;
        rsv_scatter_gather(p->sources, (uint32_t)node, row);
        rsv_status status = store_row(p->sources->context, row, block);
        if (status != RSV_OK) return status;
        p->row_begin[node + 1] = row->count;
    }
    return RSV_OK;
}

typedef struct gather_job {
    rsv_subsurface *rows;
    row_block *blocks; ///< [share.count] out
    rsv_share share;
    _Atomic rsv_status status;
} gather_job;

static void gather_shared(void *data, int worker)
{
    gather_job *job = data;
    const rsv_scatter_sources *sources = job->rows->sources;
    rsv_scatter_row row;
    rsv_status status = rsv_scatter_row_create(sources, &row);
    for (rsv_span s; rsv_share_take(&job->share, worker, &s);)
        for (size_t k = s.begin; k < s.end; k++)
            if (status == RSV_OK && !rsv_cancelled(sources->context))
                status = gather_block(job->rows, k, &row, &job->blocks[k]);
    rsv_scatter_row_destroy(&row);
    rsv_keep_failure(&job->status, status);
}

static rsv_status gather_blocks(rsv_subsurface *p, row_block *blocks, size_t block_count)
{
    rsv_context *context = p->sources->context;
    gather_job job = { p, blocks, rsv_share_of(block_count, 1), RSV_OK };
    rsv_parallel_workers(context, block_count, gather_shared, &job);
    rsv_status result = job.status;
    if (result == RSV_ERROR_MEMORY)
        return rsv_fail(result, "out of memory assembling subsurface scattering");
    return result == RSV_OK ? rsv_progress(context, "subsurface", 0.9) : result;
}

static rsv_status join_blocks(rsv_subsurface *p, const row_block *blocks, size_t block_count)
{
    for (size_t row = 0; row < p->row_count; row++)
        p->row_begin[row + 1] += p->row_begin[row];
    size_t total = p->row_begin[p->row_count], at = 0;
    p->column = rsv_alloc(p->sources->context, total, sizeof *p->column);
    p->weight = rsv_alloc(p->sources->context, total, sizeof *p->weight);
    if (!p->column || !p->weight) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < block_count; k++) {
        if (blocks[k].count == 0) continue;
        memcpy(p->column + at, blocks[k].column, blocks[k].count * sizeof *p->column);
        memcpy(p->weight + at, blocks[k].weight, blocks[k].count * sizeof *p->weight);
        at += blocks[k].count;
    }
    return RSV_OK;
}

static rsv_rgb rgb_larger(rsv_rgb a, rsv_rgb b)
{
    return rgb(f_max(a.r, b.r), f_max(a.g, b.g), f_max(a.b, b.b));
}

/// Sums of rows, 1 at least, in `entered`, which is free until the first product.
static void sum_rows(void *job, rsv_span span)
{
    rsv_subsurface *p = job;
    for (size_t row = span.begin; row < span.end; row++) {
        rsv_rgb sum = rgb_gray(0);
        for (size_t k = p->row_begin[row]; k < p->row_begin[row + 1]; k++)
            sum = rgb_add(sum, p->weight[k]);
        p->entered[row] = rgb_larger(sum, rgb_gray(1));
    }
}

static void divide_rows(void *job, rsv_span span)
{
    rsv_subsurface *p = job;
    const rsv_rgb *most = p->entered;
    for (size_t row = span.begin; row < span.end; row++)
        for (size_t k = p->row_begin[row]; k < p->row_begin[row + 1]; k++) {
            rsv_rgb divisor = rgb_larger(most[row], most[p->column[k]]), w = p->weight[k];
            p->weight[k] = rgb(w.r / divisor.r, w.g / divisor.g, w.b / divisor.b);
        }
}

/// Divides every entry by the larger one of its row's and its column's max(1, N); N is the sum of a row.
static rsv_status keep_energy(rsv_subsurface *p)
{
    const rsv_scatter_sources *s = p->sources;
    rsv_parallel_for(s->context, p->row_count, 0, sum_rows, p);
    rsv_elements_constrain(s->elements, p->entered);
    rsv_scatter_collect(s, p->entered);
    rsv_parallel_for(s->context, p->row_count, 0, divide_rows, p);
    return rsv_progress(s->context, "subsurface", 1);
}

static rsv_status assemble(rsv_subsurface *p)
{
    rsv_context *context = p->sources->context;
    rsv_status status;
    size_t block_count = (p->row_count + ROWS_PER_BLOCK - 1) / ROWS_PER_BLOCK;
    row_block *blocks = rsv_alloc(context, block_count, sizeof *blocks);
    p->row_begin = rsv_alloc(context, p->row_count + 1, sizeof *p->row_begin);
    p->entered = rsv_alloc(context, p->row_count + p->sources->cluster_count, sizeof *p->entered);
    if (!blocks || !p->row_begin || !p->entered) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(gather_blocks(p, blocks, block_count));
    RSV_TRY(join_blocks(p, blocks, block_count));
    RSV_TRY(keep_energy(p));
cleanup:
    for (size_t k = 0; blocks && k < block_count; k++) {
        rsv_free(context, blocks[k].column);
        rsv_free(context, blocks[k].weight);
    }
    rsv_free(context, blocks);
    return status;
}

rsv_status rsv_subsurface_create(const rsv_elements *elements, rsv_subsurface **subsurface)
{
    rsv_status status;
    rsv_scatter_sources *sources = NULL;
    rsv_subsurface *p = NULL;
    *subsurface = NULL;
    RSV_TRY(rsv_scatter_sources_create(elements, &sources));
    if (!sources) return RSV_OK;
    p = rsv_alloc(elements->context, 1, sizeof *p);
    if (!p) {
        rsv_scatter_sources_destroy(sources);
        return RSV_ERROR_MEMORY;
    }
    p->sources = sources;
    p->row_count = elements->node_count;
    RSV_TRY(assemble(p));
    *subsurface = p;
    p = NULL;
cleanup:
    rsv_subsurface_destroy(p);
    return status;
}

static void free_rows(rsv_context *context, const rsv_subsurface *rows)
{
    rsv_free(context, rows->row_begin);
    rsv_free(context, rows->column);
    rsv_free(context, rows->weight);
}

rsv_status rsv_subsurface_restore(
    const rsv_elements *elements, const rsv_subsurface *rows, rsv_subsurface **subsurface)
{
    rsv_status status;
    rsv_context *context = elements->context;
    rsv_scatter_sources *sources = NULL;
    rsv_subsurface *p = rsv_alloc(context, 1, sizeof *p);
    if (!p) RSV_TRY(RSV_ERROR_MEMORY);
    RSV_TRY(rsv_scatter_sources_create(elements, &sources));
    if (!sources)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "subsurface: there is no translucent material"));
    size_t columns = rows->row_count + sources->cluster_count;
    for (size_t k = 0; k < rows->row_begin[rows->row_count]; k++)
        if (rows->column[k] >= columns)
            RSV_TRY(rsv_fail(
                RSV_ERROR_FORMAT, "subsurface: column %u of %zu", rows->column[k], columns));
    *p = *rows;
    p->sources = sources;
    p->entered = rsv_alloc(context, columns, sizeof *p->entered);
    if (!p->entered) RSV_TRY(RSV_ERROR_MEMORY);
    *subsurface = p;
    return RSV_OK;
cleanup:
    free_rows(context, rows);
    rsv_scatter_sources_destroy(sources);
    rsv_free(context, p);
    return status;
}

void rsv_subsurface_destroy(rsv_subsurface *p)
{
    if (!p) return;
    rsv_context *context = p->sources->context;
    rsv_scatter_sources_destroy(p->sources);
    free_rows(context, p);
    rsv_free(context, p->entered);
    rsv_free(context, p);
}

size_t rsv_subsurface_entries(const rsv_subsurface *p)
{
    return p ? p->row_begin[p->row_count] : 0;
}

size_t rsv_subsurface_bytes(const rsv_subsurface *p)
{
    return rsv_subsurface_entries(p) * (p ? sizeof *p->column + sizeof *p->weight : 0) +
           (p ? p->row_count * sizeof *p->row_begin : 0);
}

typedef struct product_job {
    const rsv_subsurface *rows;
    rsv_rgb *diffused; ///< [row_count] out
} product_job;

static void multiply_rows(void *job, rsv_span span)
{
    const rsv_subsurface *p = ((const product_job *)job)->rows;
    rsv_rgb *diffused = ((const product_job *)job)->diffused;
    for (size_t row = span.begin; row < span.end; row++) {
        if (!has_row(p->sources, (uint32_t)row)) continue;
        rsv_rgb sum = rgb_gray(0);
        for (size_t k = p->row_begin[row]; k < p->row_begin[row + 1]; k++)
            sum = rgb_add(sum, rgb_mul(p->weight[k], p->entered[p->column[k]]));
        diffused[row] = sum;
    }
}

void rsv_subsurface_apply(
    rsv_subsurface *p, const rsv_elements *e, const rsv_rgb *irradiance, rsv_rgb *diffused)
{
    memcpy(diffused, irradiance, e->node_count * sizeof *diffused);
    if (!p) return;
    memcpy(p->entered, irradiance, e->node_count * sizeof *p->entered);
    rsv_scatter_collect(p->sources, p->entered);
    product_job job = { p, diffused };
    rsv_parallel_for(e->context, p->row_count, 256, multiply_rows, &job);
    rsv_elements_constrain(e, diffused);
}

void rsv_subsurface_apply_transpose(
    rsv_subsurface *p, const rsv_elements *e, rsv_rgb *diffused, rsv_rgb *irradiance)
{
    if (!p) {
        memcpy(irradiance, diffused, e->node_count * sizeof *irradiance);
        return;
    }
    rsv_elements_constrain_transpose(e, 1, diffused);
    memset(p->entered, 0, (p->row_count + p->sources->cluster_count) * sizeof *p->entered);
    for (size_t row = 0; row < p->row_count; row++) {
        if (!has_row(p->sources, (uint32_t)row)) {
            p->entered[row] = rgb_add(p->entered[row], diffused[row]);
            continue;
        }
        for (size_t k = p->row_begin[row]; k < p->row_begin[row + 1]; k++) {
            rsv_rgb *entered = &p->entered[p->column[k]];
            *entered = rgb_add(*entered, rgb_mul(p->weight[k], diffused[row]));
        }
    }
    rsv_scatter_collect_transpose(p->sources, p->entered);
    memcpy(irradiance, p->entered, e->node_count * sizeof *irradiance);
}
