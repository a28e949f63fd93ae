#include "row_reader.h"

#include "../core/parallel.h"

#include <string.h>

/// A record of a blob, and whether it is intact.
typedef struct listed_record {
    size_t at, bytes;
    uint32_t node;
    bool sound;
} listed_record;

/// Goes from header to header. @param list out, freed by the caller
static rsv_status list_records(
    const rsv_row_reader *r, const rsv_blob *blob, listed_record **list, size_t *count)
{
    size_t capacity = 0, at = 0;
    *list = NULL;
    *count = 0;
    for (;;) {
        listed_record next = { .at = at };
        next.bytes = rsv_row_record_bytes(
            blob->byte + at, blob->count - at, r->node_count, r->ray_count, &next.node);
        if (next.bytes == 0) return RSV_OK;
        rsv_status status =
            rsv_grow(r->context, (void **)list, &capacity, *count + 1, sizeof **list);
        if (status != RSV_OK) return status;
        (*list)[(*count)++] = next;
        at += next.bytes;
    }
}

typedef struct record_job {
    const rsv_row_reader *reader;
    const rsv_blob *blob;
    listed_record *list;
} record_job;

static void check_records(void *data, rsv_span span)
{
    const record_job *job = data;
    for (size_t k = span.begin; k < span.end; k++) {
        listed_record *record = &job->list[k];
        record->sound = rsv_row_record_is_sound(
            job->blob->byte + record->at, record->bytes, job->reader->node_count);
    }
}

/// Notes the records of a blob. @param end out: bytes up to the first that is not sound
static rsv_status index_records(rsv_row_reader *r, const rsv_blob *blob, size_t *end)
{
    listed_record *list;
    size_t count;
    *end = 0;
    rsv_status status = list_records(r, blob, &list, &count);
    record_job job = { r, blob, list };
    rsv_parallel_for(r->context, count, 0, check_records, &job);
    for (size_t k = 0; k < count && list[k].sound; k++) {
        r->known[list[k].node] = (rsv_blob){ blob->byte + list[k].at, list[k].bytes };
        *end = list[k].at + list[k].bytes;
    }
    rsv_free(r->context, list);
    return status;
}

/// A part of a blob, held until the reader is closed.
static rsv_status hold(rsv_row_reader *r, const char *name, size_t part, rsv_blob *blob)
{
    rsv_status status = r->store->table->read(r->store, name, part, blob);
    if (status != RSV_OK || blob->count == 0) return status;
    status =
        rsv_grow(r->context, (void **)&r->blob, &r->capacity, r->blob_count + 1, sizeof *r->blob);
    if (status == RSV_OK)
        r->blob[r->blob_count++] = *blob;
    else
        r->store->table->release(r->store, blob);
    return status;
}

/// A search among the names of a store.
typedef struct search {
    rsv_row_reader *reader;
    const char *key, *own;
    size_t *own_bytes;
} search;

static bool is_named(const char *name, const char *key)
{
    size_t length = strlen(name), ending = strlen(".rows");
    return strncmp(name, key, RSV_ROW_KEY_DIGITS) == 0 && length > ending &&
           strcmp(name + length - ending, ".rows") == 0;
}

static rsv_status read_blob(void *user, const char *name)
{
    search *s = user;
    size_t sound = 0, bytes = 0;
    rsv_blob blob;
    if (!is_named(name, s->key)) return RSV_OK;
    for (size_t part = 0;; part++) {
        rsv_status status = hold(s->reader, name, part, &blob);
        if (status != RSV_OK) return status;
        if (blob.count == 0) break;
        status = index_records(s->reader, &blob, &bytes);
        if (status != RSV_OK) return status;
        sound += bytes;
    }
    if (s->own && strcmp(name, s->own) == 0) *s->own_bytes = sound;
    return RSV_OK;
}

rsv_status rsv_row_reader_open(
    rsv_row_reader *r, const char *key, const char *own, size_t *own_bytes)
{
    search s = { r, key, own, own_bytes };
    r->known = rsv_alloc(r->context, r->node_count, sizeof *r->known);
    if (!r->known) return RSV_ERROR_MEMORY;
    return r->store->table->list(r->store, read_blob, &s);
}

const uint8_t *rsv_row_reader_find(const rsv_row_reader *r, uint32_t node)
{
    const rsv_blob *record = &r->known[node];
    uint32_t there;
    if (record->count == 0) return NULL;
    size_t bytes =
        rsv_row_record_bytes(record->byte, record->count, r->node_count, r->ray_count, &there);
    bool sound =
        bytes && there == node && rsv_row_record_is_sound(record->byte, bytes, r->node_count);
    return sound ? record->byte : NULL;
}

void rsv_row_reader_close(rsv_row_reader *r)
{
    if (!r->context) return;
    for (size_t k = 0; k < r->blob_count; k++)
        r->store->table->release(r->store, &r->blob[k]);
    rsv_free(r->context, r->blob);
    rsv_free(r->context, r->known);
    *r = (rsv_row_reader){ 0 };
}
