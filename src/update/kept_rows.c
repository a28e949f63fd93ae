#include "kept_rows.h"

#include "../core/index_map.h"
#include "../core/parallel.h"
#include "history_internal.h"
#include "update.h"

#include <string.h>

static bool is_catalogue(const char *name)
{
    return strlen(name) == RSV_ROW_KEY_DIGITS + strlen(".scene") &&
           strcmp(name + RSV_ROW_KEY_DIGITS, ".scene") == 0;
}

static rsv_status map_keys(
    rsv_context *context, const uint64_t *key, size_t count, rsv_index_map *map)
{
    rsv_status status = rsv_index_map_create(context, count, map);
    for (size_t k = 0; k < count && status == RSV_OK; k++)
        if (rsv_index_map_insert(map, key[k], (uint32_t)k) == UINT32_MAX) status = RSV_ERROR_MEMORY;
    return status;
}

/// The node now whose row may have the rays of a row then; RSV_NONE = none.
static uint32_t find_row(const rsv_row_catalogue *then, size_t node, const rsv_row_catalogue *now,
    const rsv_index_map *nodes)
{
    uint32_t same =
        then->has_row[node] ? rsv_index_map_find(nodes, then->node_key[node]) : RSV_NONE;
    return same != RSV_NONE && now->has_row[same] ? same : RSV_NONE;
}

static size_t count_known(
    const rsv_row_catalogue *then, const rsv_row_catalogue *now, const rsv_index_map *nodes)
{
    size_t known = 0;
    for (size_t n = 0; n < then->header->node_count; n++)
        known += find_row(then, n, now, nodes) != RSV_NONE;
    return known;
}

/// The catalogue in a store with the most known rows, among those searched.
typedef struct best_catalogue {
    rsv_store *store;
    const rsv_row_catalogue *now;
    const rsv_index_map *nodes;
    size_t known;
    rsv_row_catalogue *catalogue; ///< NULL = none
    char key[RSV_ROW_KEY_DIGITS + 1];
} best_catalogue;

static rsv_status look_at(void *user, const char *name)
{
    best_catalogue *best = user;
    const rsv_row_catalogue *now = best->now;
    rsv_row_catalogue *then = NULL;
    if (!is_catalogue(name)) return RSV_OK;
    rsv_status status = rsv_row_catalogue_read(now->context, best->store, name, &then);
    bool alike = then && then->header->ray_count == now->header->ray_count &&
                 then->header->seed == now->header->seed;
    size_t known = alike ? count_known(then, now, best->nodes) : 0;
    if (known > best->known) {
        rsv_row_catalogue *swap = best->catalogue;
        best->catalogue = then;
        then = swap;
        best->known = known;
        memcpy(best->key, name, RSV_ROW_KEY_DIGITS);
    }
    rsv_row_catalogue_destroy(then);
    return status;
}

/// Matches nodes, and drops those with a changed cell around them, because another node may get a ray's end there.
static rsv_status match_ends(const rsv_row_catalogue *then, const rsv_row_catalogue *now,
    const rsv_index_map *nodes, uint32_t *end_now)
{
    rsv_context *context = now->context;
    rsv_index_map cells = { 0 };
    rsv_status status;
    uint8_t *lost = rsv_alloc(context, then->header->node_count, 1);
    RSV_TRY(lost ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(map_keys(context, now->cell_key, now->header->cell_count, &cells));
    for (size_t n = 0; n < then->header->node_count; n++)
        end_now[n] = rsv_index_map_find(nodes, then->node_key[n]);
    for (size_t c = 0; c < then->header->cell_count; c++) {
        const uint32_t *node = then->cell_node[c];
        uint32_t same = rsv_index_map_find(&cells, then->cell_key[c]);
        for (int k = 0; k < 3; k++)
            if (same == UINT32_MAX || now->cell_node[same][k] != end_now[node[k]])
                lost[node[0]] = lost[node[1]] = lost[node[2]] = 1;
    }
    for (size_t n = 0; n < then->header->node_count; n++)
        if (lost[n]) end_now[n] = RSV_NONE;
cleanup:
    rsv_index_map_destroy(&cells);
    rsv_free(context, lost);
    return status;
}

static rsv_status match(rsv_kept_rows *e, const rsv_row_catalogue *then,
    const rsv_row_catalogue *now, const rsv_index_map *nodes)
{
    size_t count = now->header->node_count;
    e->row_before = rsv_alloc(e->context, count, sizeof *e->row_before);
    e->end_now = rsv_alloc(e->context, then->header->node_count, sizeof *e->end_now);
    if (!e->row_before || !e->end_now) return RSV_ERROR_MEMORY;
    memset(e->row_before, 0xff, count * sizeof *e->row_before);
    for (uint32_t n = 0; n < then->header->node_count; n++) {
        uint32_t same = find_row(then, n, now, nodes);
        if (same != RSV_NONE) e->row_before[same] = n;
    }
    return match_ends(then, now, nodes, e->end_now);
}

typedef struct end_job {
    const rsv_elements *elements;
    rsv_vec3 (*box)[2]; ///< [node_count]
} end_job;

static void box_ends(void *data, rsv_span span)
{
    const end_job *job = data;
    const rsv_elements *elements = job->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        rsv_box all = { v3(INFINITY, INFINITY, INFINITY), v3(-INFINITY, -INFINITY, -INFINITY) };
        for (uint32_t s = elements->support_begin[n]; s < elements->support_begin[n + 1]; s++) {
            rsv_box cell = rsv_box_of_cell(elements, elements->support[s] / 4);
            all.low = v3_min(all.low, cell.low);
            all.high = v3_max(all.high, cell.high);
        }
        job->box[n][0] = all.low;
        job->box[n][1] = all.high;
    }
}

/// Rays that ended at a node did so in a cell around it.
static rsv_status find_end_boxes(rsv_kept_rows *e, const rsv_elements *elements)
{
    e->end_box = rsv_alloc(e->context, elements->node_count, sizeof *e->end_box);
    if (!e->end_box) return RSV_ERROR_MEMORY;
    end_job job = { elements, e->end_box };
    rsv_parallel_for(e->context, elements->node_count, 256, box_ends, &job);
    return RSV_OK;
}

static void find_changes(
    rsv_kept_rows *e, const rsv_row_basis *basis, const rsv_row_catalogue *then)
{
    const rsv_history *history = rsv_history_of(basis->scene);
    if (history) {
        e->added = *rsv_history_added(history);
        e->change = *rsv_history_change(history);
        return;
    }
    e->added = e->change = rsv_scene_change_since(
        basis->scene->view, then->triangle_key, then->header->triangle_count);
}

static rsv_status open_rows(
    const rsv_row_basis *basis, const best_catalogue *best, rsv_kept_rows *e)
{
    const rsv_row_catalogue *then = best->catalogue;
    e->seconds = then->header->seconds;
    find_changes(e, basis, then);
    rsv_status status = match(e, then, best->now, best->nodes);
    if (status == RSV_OK) status = find_end_boxes(e, basis->elements);
    e->reader = (rsv_row_reader){ .context = e->context,
        .store = best->store,
        .node_count = then->header->node_count,
        .ray_count = best->now->header->ray_count };
    return status == RSV_OK ? rsv_row_reader_open(&e->reader, best->key, NULL, NULL) : status;
}

rsv_status rsv_kept_rows_open(const rsv_row_basis *basis, const rsv_row_catalogue *now,
    rsv_store *store, rsv_kept_rows **earlier)
{
    rsv_context *context = now->context;
    rsv_status status;
    rsv_index_map nodes = { 0 };
    best_catalogue best = { .store = store, .now = now, .nodes = &nodes };
    rsv_kept_rows *e = NULL;
    *earlier = NULL;
    RSV_TRY(map_keys(context, now->node_key, now->header->node_count, &nodes));
    status = store->table->list(store, look_at, &best);
    if (status == RSV_ERROR_IO) status = RSV_OK; // then none is known
    RSV_TRY(status);
    if (!best.catalogue) goto cleanup;
    e = rsv_alloc(context, 1, sizeof *e);
    RSV_TRY(e ? RSV_OK : RSV_ERROR_MEMORY);
    e->context = context;
    RSV_TRY(open_rows(basis, &best, e));
    *earlier = e;
    e = NULL;
cleanup:
    rsv_kept_rows_close(e);
    rsv_row_catalogue_destroy(best.catalogue);
    rsv_index_map_destroy(&nodes);
    return status;
}

void rsv_kept_rows_close(rsv_kept_rows *e)
{
    if (!e) return;
    rsv_row_reader_close(&e->reader);
    rsv_free(e->context, e->row_before);
    rsv_free(e->context, e->end_now);
    rsv_free(e->context, e->end_box);
    rsv_free(e->context, e);
}

bool rsv_kept_rows_find(const rsv_kept_rows *e, uint32_t node, rsv_kept_row *row)
{
    uint32_t then = e ? e->row_before[node] : RSV_NONE;
    const uint8_t *record = then == RSV_NONE ? NULL : rsv_row_reader_find(&e->reader, then);
    if (!record) return false;
    *row = rsv_row_record_kept(record);
    row->end_now = e->end_now;
    row->end_box = (const rsv_vec3(*)[2])e->end_box;
    row->added = &e->added;
    row->change = &e->change;
    return true;
}
