#include "checkpoint.h"

#include "../core/key.h"
#include "../core/team.h"
#include "earlier_rows.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct rsv_checkpoint {
    rsv_context *context;
    uint32_t ray_count;
    rsv_row_files files; ///< of earlier runs
    rsv_row_catalogue *catalogue;
    rsv_earlier_rows *earlier; ///< of the scene before it was edited; NULL = none
    int descriptor;            ///< of the file that grows
    int error;                 ///< errno of what could not be written; 0 = all was
    size_t own_bytes;          ///< of sound records that it had
    char path[RSV_ROW_PATH_BYTES], catalogue_path[RSV_ROW_PATH_BYTES];
};

static uint64_t key_of(const rsv_row_tracer *t)
{
    const rsv_elements *e = t->elements;
    uint64_t key = rsv_key_add(rsv_key_add(e->node_count, t->directions.count), t->seed);
    for (uint32_t c = 0; c < e->cell_count; c++) {
        const rsv_cell *cell = &e->cell[c];
        key = rsv_key_add(key, (uint64_t)cell->face << 32 | (uint64_t)cell->i << 16 | cell->j);
        key = rsv_key_add(key, (uint64_t)cell->level << 8 | cell->flipped);
    }
    key = rsv_key_add_bytes(key, e->cell_node, e->cell_count * sizeof *e->cell_node);
    if (e->node_draw)
        key = rsv_key_add_bytes(key, e->node_draw, e->node_count * sizeof *e->node_draw);
    return rsv_key_add_bytes(key, t->valid_points, e->node_count * sizeof *t->valid_points);
}

bool rsv_checkpoint_take(const rsv_checkpoint *c, uint32_t node, rsv_row_scratch *scratch)
{
    const uint8_t *record = c ? rsv_row_files_find(&c->files, node) : NULL;
    if (record) rsv_row_record_take(record, c->ray_count, scratch);
    return record != NULL;
}

bool rsv_checkpoint_recall(const rsv_checkpoint *c, uint32_t node, rsv_row_past *past)
{
    return c && rsv_earlier_rows_find(c->earlier, node, past);
}

rsv_status rsv_checkpoint_keep(rsv_checkpoint *c, uint32_t node, const rsv_row_scratch *scratch,
    uint64_t rays, rsv_row_block *block)
{
    return rsv_row_record_put(c->context, node, c->ray_count, scratch, rays, block);
}

rsv_status rsv_checkpoint_write(rsv_checkpoint *c, rsv_row_block *b)
{
    rsv_status status = RSV_OK;
    if (!c) return status;
#pragma omp critical(rsv_checkpoint)
    {
        for (size_t done = 0; c->error == 0 && done < b->count;) {
            ssize_t written = write(c->descriptor, b->byte + done, b->count - done);
            if (written >= 0)
                done += (size_t)written;
            else if (errno != EINTR)
                c->error = errno;
        }
        if (c->error != 0) status = RSV_ERROR_IO;
    }
    b->count = 0;
    return status;
}

rsv_status rsv_checkpoint_outcome(const rsv_checkpoint *c)
{
    if (!c || c->error == 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_IO,
        "checkpoint: cannot write '%s': %s; with that mended, the same command goes on with the "
        "rows that are there",
        c->path, strerror(c->error));
}

double rsv_checkpoint_finish(rsv_checkpoint *c, double seconds)
{
    if (!c) return 0;
    c->catalogue->header->seconds = c->earlier ? c->earlier->seconds : seconds;
    if (rsv_team_place_of(c->context).rank == 0)
        rsv_row_catalogue_write(c->catalogue, c->catalogue_path);
    return c->earlier ? c->earlier->seconds - seconds : 0;
}

/// Goes on behind the last sound record.
static rsv_status open_own(rsv_checkpoint *c)
{
    c->descriptor = open(c->path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (c->descriptor < 0 || ftruncate(c->descriptor, (off_t)c->own_bytes) != 0 ||
        lseek(c->descriptor, 0, SEEK_END) < 0)
        return rsv_fail(
            RSV_ERROR_IO, "checkpoint: cannot write '%s': %s", c->path, strerror(errno));
    return RSV_OK;
}

static void report(const rsv_checkpoint *c)
{
    size_t known = 0;
    for (size_t n = 0; n < c->files.node_count; n++)
        known += c->files.known[n] != NULL;
    if (known)
        rsv_log(c->context, RSV_LOG_INFO, "checkpoint: %zu rows of %u rays are known already",
            known, c->ray_count);
}

static rsv_status name_files(rsv_checkpoint *c, const char *folder, const char *key)
{
    uint32_t rank = rsv_team_place_of(c->context).rank;
    int length = snprintf(c->path, sizeof c->path, "%s/%s-%u.rows", folder, key, rank);
    snprintf(c->catalogue_path, sizeof c->catalogue_path, "%s/%s.scene", folder, key);
    return length < (int)sizeof c->path
               ? RSV_OK
               : rsv_fail(RSV_ERROR_IO, "checkpoint: the name of the folder is too long");
}

/// Rows of this scene, and of an earlier version of it.
static rsv_status read_rows(rsv_checkpoint *c, const rsv_row_tracer *tracer, const char *key)
{
    const rsv_transport_scene *scene = tracer->scene;
    rsv_status status;
    RSV_TRY(rsv_row_files_open(c->context, scene->checkpoint, key, tracer->elements->node_count,
        c->ray_count, c->path, &c->own_bytes, &c->files));
    RSV_TRY(rsv_row_catalogue_create(tracer, &c->catalogue));
    if (scene->earlier)
        RSV_TRY(rsv_earlier_rows_open(tracer, c->catalogue, scene->earlier, &c->earlier));
cleanup:
    return status;
}

rsv_status rsv_checkpoint_open(const rsv_row_tracer *tracer, rsv_checkpoint **checkpoint)
{
    rsv_status status;
    rsv_context *context = tracer->elements->context;
    char key[RSV_ROW_KEY_DIGITS + 1];
    *checkpoint = NULL;
    if (!tracer->scene->checkpoint) return RSV_OK;
    rsv_checkpoint *c = rsv_alloc(context, 1, sizeof *c);
    if (!c) return RSV_ERROR_MEMORY;
    c->context = context;
    c->descriptor = -1;
    c->ray_count = tracer->directions.count;
    snprintf(key, sizeof key, "%016llx", (unsigned long long)key_of(tracer));
    RSV_TRY(name_files(c, tracer->scene->checkpoint, key));
    RSV_TRY(rsv_team_meet(context, read_rows(c, tracer, key)));
    RSV_TRY(open_own(c)); // after all have read it
    report(c);
    *checkpoint = c;
    c = NULL;
cleanup:
    rsv_checkpoint_close(c);
    return status;
}

void rsv_checkpoint_close(rsv_checkpoint *c)
{
    if (!c) return;
    rsv_earlier_rows_close(c->earlier);
    rsv_row_catalogue_destroy(c->catalogue);
    rsv_row_files_close(&c->files);
    if (c->descriptor >= 0) close(c->descriptor);
    rsv_free(c->context, c);
}
