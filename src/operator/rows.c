/// Assembly of G: rows traced in blocks by all threads, then moved to the operator in their order.
#include "../core/parallel.h"
#include "../core/team.h"
#include "../update/row_store.h"
#include "../update/update.h"
#include "operator_constants.h"
#include "row_device.h"
#include "stored_rows_internal.h"
#include "transport_lists.h"

#include <stdlib.h>
#include <string.h>

/// Rows on their way to the operator.
typedef struct row_block {
    uint32_t *column, *tinted_column;
    rsv_rgb *tinted_weight;
    size_t count, tinted_count;
    size_t place, tinted_place; ///< in the operator
    size_t column_capacity, tinted_column_capacity, tinted_weight_capacity;
    rsv_escape_list escapes;
    rsv_row_block kept;
} row_block;

typedef struct assembly {
    rsv_row_tracer tracer;
    rsv_row_store *store; ///< NULL = rows are not kept
    rsv_transport *transport;
    rsv_division *division; ///< until the transport owns it
    uint32_t *node;         ///< [row_count] whose rows are traced here, in ascending order
    size_t row_count;
    rsv_row_scratch *scratch; ///< [threads]
    row_block *block;         ///< [wave_size]
    size_t block_count, wave_size;
    size_t entries, tinted_entries; ///< in the operator
    rsv_row_device *device;         ///< that traces rays; NULL = none
    bool on_device;                 ///< it has traced those of the wave
} assembly;

static rsv_status reserve_row(rsv_context *context, row_block *block, size_t count, size_t tinted)
{
    rsv_status status;
    RSV_TRY(rsv_grow(context, (void **)&block->column, &block->column_capacity,
        block->count + count, sizeof *block->column));
    RSV_TRY(rsv_grow(context, (void **)&block->tinted_column, &block->tinted_column_capacity,
        block->tinted_count + tinted, sizeof *block->tinted_column));
    RSV_TRY(rsv_grow(context, (void **)&block->tinted_weight, &block->tinted_weight_capacity,
        block->tinted_count + tinted, sizeof *block->tinted_weight));
cleanup:
    return status;
}

static rsv_status store_row(assembly *a, uint32_t node, const rsv_row_scratch *s, row_block *block)
{
    rsv_transport *t = a->transport;
    uint32_t rays = a->tracer.directions.count;
    rsv_status status = reserve_row(t->context, block, rays, s->tinted_count);
    if (status != RSV_OK) return status;
    size_t first = block->count;
    for (uint32_t ray = 0; ray < rays; ray++)
        if (s->column[ray] != RSV_NONE) block->column[block->count++] = s->column[ray];
    for (uint32_t k = 0; k < s->tinted_count; k++) {
        block->tinted_column[block->tinted_count] = s->tinted_column[k];
        block->tinted_weight[block->tinted_count++] = s->tinted_weight[k];
    }
    rsv_stored_rows *rows = rsv_stored_rows_of(t);
    rows->row_begin[node + 1] = block->count - first; // summed up in the end
    rows->tinted_begin[node + 1] = s->tinted_count;
    t->scale[node] = 1 / (float)rays;
    t->gathered[node] = rgb_scale(s->emission, RSV_PI * t->scale[node]);
    if (!a->tracer.scene->view->environment) return RSV_OK; // directions of escaped rays are not needed
    return rsv_escapes_store(t->context, &t->escapes, node, &s->escapes, &block->escapes);
}

/// Traces a row unless an earlier run or the device did; only in part, if it was traced before the scene was edited.
/// @param index of the row in the wave
static rsv_status find_row(
    assembly *a, uint32_t node, size_t index, rsv_row_scratch *scratch, row_block *block)
{
    if (a->on_device) {
        rsv_row_device_finish(a->device, index, scratch);
        return RSV_OK;
    }
    uint64_t before = scratch->rays;
    if (rsv_row_store_take(a->store, node, scratch)) return RSV_OK;
    rsv_kept_row kept;
    if (rsv_row_store_find_kept(a->store, node, &kept))
        rsv_row_retrace(&a->tracer, node, &kept, scratch);
    else
        rsv_row_trace(&a->tracer, node, scratch);
    if (!a->store) return RSV_OK;
    return rsv_row_store_keep(a->store, node, scratch, scratch->rays - before, &block->kept);
}

/// @param wave its first block
static rsv_status trace_block(
    assembly *a, size_t wave, size_t index, rsv_row_scratch *scratch, row_block *block)
{
    size_t begin = index * RSV_ROW_BLOCK, end = begin + RSV_ROW_BLOCK;
    if (end > a->row_count) end = a->row_count;
    for (size_t k = begin; k < end; k++) {
        size_t in_wave = k - wave * RSV_ROW_BLOCK;
        rsv_status status = find_row(a, a->node[k], in_wave, scratch, block);
        if (status == RSV_OK) status = store_row(a, a->node[k], scratch, block);
        if (status != RSV_OK) return status;
    }
    return rsv_row_store_write(a->store, &block->kept);
}

/// Has the device trace the rays of a wave, if there is one.
static rsv_status trace_on_device(assembly *a, size_t first)
{
    size_t begin = first * RSV_ROW_BLOCK, count = a->wave_size * RSV_ROW_BLOCK;
    if (count > a->row_count - begin) count = a->row_count - begin;
    return rsv_row_device_trace(a->device, a->node + begin, count, &a->on_device);
}

/// Blocks that all workers trace before they move to the operator.
typedef struct wave {
    assembly *assembly;
    size_t first;       ///< its first block
    atomic_size_t done; ///< blocks, with those of the waves before
    _Atomic rsv_status result;
} wave;

static void trace_blocks(void *job, rsv_span span)
{
    wave *w = job;
    assembly *a = w->assembly;
    rsv_context *context = a->transport->context;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(context); k++) {
        rsv_status status =
            trace_block(a, w->first, w->first + k, &a->scratch[span.worker], &a->block[k]);
        rsv_item_done(context, "assemble", span.worker, &w->done, a->block_count);
        if (status == RSV_OK) continue;
        rsv_keep_failure(&w->result, status);
        rsv_team_alarm(context);
    }
}

static rsv_status trace_wave(assembly *a, size_t first)
{
    size_t left = a->block_count - first;
    wave w = { .assembly = a, .first = first, .done = first };
    rsv_parallel_for(
        a->transport->context, left < a->wave_size ? left : a->wave_size, 1, trace_blocks, &w);
    return w.result;
}

static void copy_rows(const row_block *block, rsv_stored_rows *t)
{
    if (block->count)
        memcpy(t->column + block->place, block->column, block->count * sizeof *t->column);
    if (block->tinted_count) {
        memcpy(t->tinted_column + block->tinted_place, block->tinted_column,
            block->tinted_count * sizeof *t->tinted_column);
        memcpy(t->tinted_weight + block->tinted_place, block->tinted_weight,
            block->tinted_count * sizeof *t->tinted_weight);
    }
}

static void move_blocks(void *job, rsv_span span)
{
    assembly *a = job;
    for (size_t k = span.begin; k < span.end; k++) {
        copy_rows(&a->block[k], rsv_stored_rows_of(a->transport));
        a->block[k].count = a->block[k].tinted_count = 0;
    }
}

/// Moves the rows of all blocks of a wave, one behind the other, behind those of the waves before.
static rsv_status append_wave(assembly *a)
{
    rsv_transport *t = a->transport;
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < a->wave_size; k++) {
        a->block[k].place = a->entries;
        a->block[k].tinted_place = a->tinted_entries;
        a->entries += a->block[k].count;
        a->tinted_entries += a->block[k].tinted_count;
    }
    rsv_parallel_for(t->context, a->wave_size, 0, move_blocks, a);
    for (size_t k = 0; k < a->wave_size && status == RSV_OK; k++)
        status = rsv_escapes_append(t->context, &t->escapes, &a->block[k].escapes);
    return status;
}

static void sum_up_rows(rsv_transport *t)
{
    rsv_stored_rows *rows = rsv_stored_rows_of(t);
    for (size_t row = 0; row < t->row_count; row++) {
        rows->row_begin[row + 1] += rows->row_begin[row];
        rows->tinted_begin[row + 1] += rows->tinted_begin[row];
    }
    rsv_escapes_finish(&t->escapes, t->row_count);
}

static rsv_status trace_all(assembly *a)
{
    rsv_context *context = a->transport->context;
    rsv_status status = RSV_OK;
    double start = rsv_seconds();
    for (size_t first = 0; first < a->block_count; first += a->wave_size) {
        RSV_TRY(trace_on_device(a, first));
        RSV_TRY(trace_wave(a, first));
        RSV_TRY(rsv_cancelled(context) ? rsv_progress(context, "assemble", 1) : RSV_OK);
        RSV_TRY(append_wave(a));
    }
    sum_up_rows(a->transport);
    for (int thread = 0; thread < rsv_threads(context); thread++) {
        a->transport->rays += a->scratch[thread].rays;
        a->transport->kept_rays += a->scratch[thread].kept;
        a->transport->kept_rows += a->scratch[thread].kept_rows;
    }
    a->transport->spared_seconds = rsv_row_store_finish(a->store, rsv_seconds() - start);
    RSV_TRY(rsv_progress(context, "assemble", 1));
cleanup:
    if (status == RSV_ERROR_MEMORY)
        status = rsv_fail(status, "out of memory assembling the operator");
    if (status == RSV_ERROR_IO) status = rsv_row_store_outcome(a->store);
    return rsv_team_meet(context, status);
}

/// Shares the data of every row that all processes need.
static rsv_status share_rows(rsv_transport *t)
{
    t->rays = rsv_team_total(t->context, t->rays);
    t->kept_rays = rsv_team_total(t->context, t->kept_rays);
    t->kept_rows = rsv_team_total(t->context, t->kept_rows);
    rsv_division_share(t->division, t->scale, sizeof *t->scale);
    rsv_division_share(t->division, t->gathered, sizeof *t->gathered);
    return rsv_team_meet(t->context, RSV_OK);
}

/// Memory for rows of `rays` entries each. Unused pages are never touched.
static rsv_status create_empty(const assembly *a, uint32_t rays, rsv_transport **transport)
{
    rsv_context *context = a->tracer.elements->context;
    size_t rows = a->tracer.elements->node_count, most = a->row_count * rays;
    rsv_status status = rsv_transport_create_empty(context, rows, transport);
    if (status != RSV_OK) return status;
    rsv_transport *t = *transport;
    rsv_stored_rows *r = rsv_stored_rows_of(t);
    r->row_begin = rsv_alloc(context, rows + 1, sizeof *r->row_begin);
    r->column = rsv_reserve(context, most, sizeof *r->column);
    r->tinted_begin = rsv_alloc(context, rows + 1, sizeof *r->tinted_begin);
    r->tinted_column = rsv_reserve(context, most, sizeof *r->tinted_column);
    r->tinted_weight = rsv_reserve(context, most, sizeof *r->tinted_weight);
    t->scale = rsv_alloc(context, rows, sizeof *t->scale);
    t->gathered = rsv_alloc(context, rows, sizeof *t->gathered);
    bool complete = r->row_begin && r->column && r->tinted_begin && r->tinted_column &&
                    r->tinted_weight && t->scale && t->gathered;
    return complete ? rsv_escapes_create(context, rows, &t->escapes) : RSV_ERROR_MEMORY;
}

static rsv_status create_workers(assembly *a)
{
    rsv_context *context = a->tracer.elements->context;
    size_t threads = (size_t)rsv_threads(context);
    rsv_status status = RSV_OK;
    a->wave_size =
        a->device ? rsv_row_device_most(a->device) / RSV_ROW_BLOCK : BLOCKS_PER_THREAD * threads;
    a->block = rsv_alloc(context, a->wave_size, sizeof *a->block);
    a->scratch = rsv_alloc(context, threads, sizeof *a->scratch);
    if (!a->block || !a->scratch) return RSV_ERROR_MEMORY;
    for (size_t thread = 0; thread < threads && status == RSV_OK; thread++)
        status = rsv_row_scratch_create(context, a->tracer.directions.count, &a->scratch[thread]);
    return status;
}

static void destroy_workers(assembly *a)
{
    rsv_context *context = a->tracer.elements->context;
    for (int thread = 0; a->scratch && thread < rsv_threads(context); thread++)
        rsv_row_scratch_destroy(context, &a->scratch[thread]);
    for (size_t k = 0; a->block && k < a->wave_size; k++) {
        rsv_free(context, a->block[k].column);
        rsv_free(context, a->block[k].tinted_column);
        rsv_free(context, a->block[k].tinted_weight);
        rsv_escape_list_destroy(context, &a->block[k].escapes);
        rsv_free(context, a->block[k].kept.byte);
    }
    rsv_free(context, a->block);
    rsv_free(context, a->scratch);
}

static int compare_nodes(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

/// The rows to trace: of all nodes that neither hang nor are buried, those of the division's part.
static rsv_status list_rows(assembly *a)
{
    const rsv_division *division = a->division;
    size_t first = division ? division->begin[division->part] : 0;
    size_t end = division ? division->begin[division->part + 1] : a->tracer.elements->node_count;
    a->node = rsv_alloc(a->tracer.elements->context, end - first, sizeof *a->node);
    if (!a->node) return RSV_ERROR_MEMORY;
    for (size_t k = first; k < end; k++) {
        uint32_t node = division ? division->order[k] : (uint32_t)k;
        if (a->tracer.valid_points[node]) a->node[a->row_count++] = node;
    }
    if (division) qsort(a->node, a->row_count, sizeof *a->node, compare_nodes);
    a->block_count = (a->row_count + RSV_ROW_BLOCK - 1) / RSV_ROW_BLOCK;
    return RSV_OK;
}

static void end_assembly(assembly *a)
{
    destroy_workers(a);
    rsv_row_device_destroy(a->device);
    rsv_row_store_close(a->store);
    rsv_free(a->tracer.elements->context, a->node);
    rsv_row_tracer_end(&a->tracer);
}

/// In a team, this process has a part of the rows; otherwise all of them.
static rsv_status divide_rows(assembly *a)
{
    rsv_team_place place = rsv_team_place_of(a->tracer.elements->context);
    if (place.size == 1) return RSV_OK;
    rsv_status status = rsv_row_costs(&a->tracer, &a->division);
    return status == RSV_OK ? rsv_division_cut(a->division, place.rank, place.size) : status;
}

/// Opens the store of rows, if one is requested, with rows of an earlier version of the scene.
static rsv_status open_store(assembly *a)
{
    const rsv_row_tracer *t = &a->tracer;
    if (!t->scene->update || !t->scene->update->store) return RSV_OK;
    size_t sides = 2 * (size_t)t->scene->view->triangle_count;
    uint8_t *kind = rsv_alloc(t->elements->context, sides, sizeof *kind);
    if (!kind) return RSV_ERROR_MEMORY;
    for (size_t side = 0; side < sides; side++)
        kind[side] = t->target[side].kind;
    const rsv_row_basis basis = { t->scene, t->elements, t->valid_points, kind, t->directions.count,
        t->seed };
    rsv_status status = rsv_row_store_open(&basis, &a->store);
    rsv_free(t->elements->context, kind);
    return status;
}

rsv_status rsv_transport_create(const rsv_transport_desc *d, rsv_transport **transport)
{
    rsv_status status;
    assembly a = { .tracer = {
                       d->scene, d->lights, d->elements, d->valid_points, .seed = d->seed } };
    RSV_TRY(rsv_row_tracer_begin(&a.tracer, d->rays));
    RSV_TRY(divide_rows(&a));
    RSV_TRY(list_rows(&a));
    RSV_TRY(create_empty(&a, d->rays, &a.transport));
    a.transport->division = a.division;
    a.division = NULL;
    RSV_TRY(open_store(&a));
    RSV_TRY(a.store ? RSV_OK : rsv_row_device_create(&a.tracer, a.row_count, &a.device));
    RSV_TRY(create_workers(&a));
    RSV_TRY(trace_all(&a));
    RSV_TRY(share_rows(a.transport));
    *transport = a.transport;
    a.transport = NULL;
cleanup:
    rsv_transport_destroy(a.transport);
    rsv_division_destroy(a.division);
    end_assembly(&a);
    return status;
}
