#include "row_store.h"

#include "../core/key.h"
#include "../core/team.h"
#include "kept_rows.h"
#include "update.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

struct rsv_row_store {
    rsv_context *context;
    rsv_store *store;
    uint32_t ray_count;
    rsv_row_reader reader; ///< of earlier runs
    rsv_row_catalogue *catalogue;
    rsv_kept_rows *earlier; ///< of the scene before it was edited; NULL = none
    bool open;
    pthread_mutex_t writing; ///< held by the thread that appends
    int end;                 ///< of the blob that grows, where it is open
    int error;               ///< errno of a failed write; 0 = none
    size_t own_bytes;        ///< of sound records that it had
    char name[RSV_STORE_NAME_BYTES], catalogue_name[RSV_STORE_NAME_BYTES];
};

static uint64_t key_of(const rsv_row_basis *t)
{
    const rsv_elements *e = t->elements;
    uint64_t key = rsv_key_add(rsv_key_add(e->node_count, t->ray_count), t->seed);
    for (uint32_t c = 0; c < e->cell_count; c++) {
        const rsv_cell *cell = &e->cell[c];
        key = rsv_key_add(key, (uint64_t)cell->face << 32 | (uint64_t)cell->i << 16 | cell->j);
        key = rsv_key_add(key, (uint64_t)cell->level << 8 | cell->flipped);
    }
    key = rsv_key_add_bytes(key, e->cell_node, e->cell_count * sizeof *e->cell_node);
    for (uint32_t c = 0; c < e->cell_count && e->cell_cut; c++) {
        const float *side = rsv_cell_sides(e, c);
        if (side) key = rsv_key_add_bytes(rsv_key_add(key, c), side, sizeof *e->cut_side);
    }
    if (e->node_draw)
        key = rsv_key_add_bytes(key, e->node_draw, e->node_count * sizeof *e->node_draw);
    return rsv_key_add_bytes(key, t->valid_points, e->node_count * sizeof *t->valid_points);
}

bool rsv_row_store_take(const rsv_row_store *c, uint32_t node, rsv_row_scratch *scratch)
{
    const uint8_t *record = c ? rsv_row_reader_find(&c->reader, node) : NULL;
    if (record) rsv_row_record_take(record, c->ray_count, scratch);
    return record != NULL;
}

bool rsv_row_store_find_kept(const rsv_row_store *c, uint32_t node, rsv_kept_row *row)
{
    return c && rsv_kept_rows_find(c->earlier, node, row);
}

rsv_status rsv_row_store_keep(rsv_row_store *c, uint32_t node, const rsv_row_scratch *scratch,
    uint64_t rays, rsv_row_block *block)
{
    return rsv_row_record_put(c->context, node, c->ray_count, scratch, rays, block);
}

rsv_status rsv_row_store_write(rsv_row_store *c, rsv_row_block *b)
{
    rsv_status status = RSV_OK;
    if (!c) return status;
    pthread_mutex_lock(&c->writing);
    if (c->error == 0) c->error = c->store->table->append(c->store, c->end, b->byte, b->count);
    if (c->error != 0) status = c->error == ENOMEM ? RSV_ERROR_MEMORY : RSV_ERROR_IO;
    pthread_mutex_unlock(&c->writing);
    b->count = 0;
    return status;
}

rsv_status rsv_row_store_outcome(const rsv_row_store *c)
{
    if (!c || c->error == 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_IO,
        "%s: cannot write '%s/%s': %s; once that is fixed, the same command continues with the saved rows",
        c->store->kind, c->store->place, c->name, strerror(c->error));
}

double rsv_row_store_finish(rsv_row_store *c, double seconds)
{
    if (!c) return 0;
    c->catalogue->header->seconds = c->earlier ? c->earlier->seconds : seconds;
    if (!c->store->shared || rsv_team_place_of(c->context).rank == 0)
        rsv_row_catalogue_write(c->catalogue, c->store, c->catalogue_name);
    return c->earlier ? c->earlier->seconds - seconds : 0;
}

/// Goes on behind the last sound record.
static rsv_status open_own(rsv_row_store *c)
{
    int why = c->store->table->open(c->store, c->name, c->own_bytes, &c->end);
    c->open = why == 0;
    if (why == ENOMEM) return RSV_ERROR_MEMORY;
    if (why == 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_IO, "%s: cannot write '%s/%s': %s", c->store->kind, c->store->place,
        c->name, strerror(why));
}

static void report(const rsv_row_store *c)
{
    size_t known = 0;
    for (size_t n = 0; n < c->reader.node_count; n++)
        known += c->reader.known[n].count > 0;
    if (known)
        rsv_log(c->context, RSV_LOG_INFO, "%s: %zu rows of %u rays are known already",
            c->store->kind, known, c->ray_count);
}

/// Rows of this scene, and of an earlier version of it.
static rsv_status read_rows(rsv_row_store *c, const rsv_row_basis *basis, const char *key)
{
    rsv_store *earlier = basis->scene->update->earlier;
    rsv_status status;
    c->reader = (rsv_row_reader){ .context = c->context,
        .store = c->store,
        .node_count = basis->elements->node_count,
        .ray_count = c->ray_count };
    RSV_TRY(rsv_row_reader_open(&c->reader, key, c->name, &c->own_bytes));
    RSV_TRY(rsv_row_catalogue_create(basis, &c->catalogue));
    if (earlier) RSV_TRY(rsv_kept_rows_open(basis, c->catalogue, earlier, &c->earlier));
cleanup:
    return status;
}

rsv_status rsv_row_store_open(const rsv_row_basis *basis, rsv_row_store **store)
{
    rsv_status status;
    rsv_context *context = basis->elements->context;
    char key[RSV_ROW_KEY_DIGITS + 1];
    *store = NULL;
    rsv_row_store *c = rsv_alloc(context, 1, sizeof *c);
    if (!c) return RSV_ERROR_MEMORY;
    pthread_mutex_init(&c->writing, NULL);
    c->context = context;
    c->store = basis->scene->update->store;
    c->ray_count = basis->ray_count;
    snprintf(key, sizeof key, "%016llx", (unsigned long long)key_of(basis));
    snprintf(c->name, sizeof c->name, "%s-%u.rows", key, rsv_team_place_of(context).rank);
    snprintf(c->catalogue_name, sizeof c->catalogue_name, "%s.scene", key);
    RSV_TRY(rsv_team_meet(context, read_rows(c, basis, key)));
    RSV_TRY(open_own(c)); // after all have read it
    report(c);
    *store = c;
    c = NULL;
cleanup:
    rsv_row_store_close(c);
    return status;
}

void rsv_row_store_close(rsv_row_store *c)
{
    if (!c) return;
    rsv_kept_rows_close(c->earlier);
    rsv_row_catalogue_destroy(c->catalogue);
    rsv_row_reader_close(&c->reader);
    if (c->open) c->store->table->close(c->store, c->end);
    pthread_mutex_destroy(&c->writing);
    rsv_free(c->context, c);
}
