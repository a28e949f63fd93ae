/// Blobs in memory. They are few: names are searched for one by one.
#include "store.h"

#include <errno.h>
#include <string.h>

typedef struct memory_blob {
    char name[RSV_STORE_NAME_BYTES];
    rsv_blob *part; ///< [part_count] as they were appended
    size_t part_count, part_capacity;
} memory_blob;

typedef struct memory_store {
    rsv_store store;
    memory_blob *blob; ///< [blob_count]
    size_t blob_count, blob_capacity;
} memory_store;

static memory_store *of(rsv_store *s) { return (memory_store *)(void *)s; }

/// @return NULL if there is none
static memory_blob *find(rsv_store *s, const char *name)
{
    for (size_t k = 0; k < of(s)->blob_count; k++)
        if (strcmp(of(s)->blob[k].name, name) == 0) return &of(s)->blob[k];
    return NULL;
}

static void drop_parts(rsv_context *context, memory_blob *blob, size_t keep)
{
    size_t count = 0, bytes = 0;
    while (count < blob->part_count && bytes + blob->part[count].count <= keep)
        bytes += blob->part[count++].count;
    for (size_t k = count; k < blob->part_count; k++)
        rsv_free(context, (void *)(uintptr_t)blob->part[k].byte);
    blob->part_count = count;
}

/// @return a new one after the others, which do not move; NULL if out of memory

static memory_blob *create(rsv_store *s, const char *name)
{
    memory_store *m = of(s);
    if (rsv_grow(s->context, (void **)&m->blob, &m->blob_capacity, m->blob_count + 1,
            sizeof *m->blob) != RSV_OK)
        return NULL;
    memory_blob *blob = &m->blob[m->blob_count++];
    *blob = (memory_blob){ 0 };
    strncpy(blob->name, name, RSV_STORE_NAME_BYTES - 1);
    return blob;
}

static int add_part(rsv_context *context, memory_blob *blob, const void *byte, size_t count)
{
    if (count == 0) return 0;
    if (rsv_grow(context, (void **)&blob->part, &blob->part_capacity, blob->part_count + 1,
            sizeof *blob->part) != RSV_OK)
        return ENOMEM;
    uint8_t *copy = rsv_reserve(context, count, 1);
    if (!copy) return ENOMEM;
    memcpy(copy, byte, count);
    blob->part[blob->part_count++] = (rsv_blob){ copy, count };
    return 0;
}

/// The first name behind another one; NULL if there is none.
static const char *name_after(rsv_store *s, const char *name)
{
    const char *next = NULL;
    for (size_t k = 0; k < of(s)->blob_count; k++) {
        const char *other = of(s)->blob[k].name;
        if (strcmp(other, name) > 0 && (!next || strcmp(other, next) < 0)) next = other;
    }
    return next;
}

static rsv_status list(rsv_store *s, rsv_status (*visit)(void *user, const char *name), void *user)
{
    rsv_status status = RSV_OK;
    const char *name = "";
    while (status == RSV_OK && (name = name_after(s, name)))
        status = visit(user, name);
    return status;
}

static rsv_status read_part(rsv_store *s, const char *name, size_t part, rsv_blob *blob)
{
    const memory_blob *m = find(s, name);
    *blob = m && part < m->part_count ? m->part[part] : (rsv_blob){ 0 };
    return RSV_OK;
}

static void release(rsv_store *s, rsv_blob *blob)
{
    (void)s;
    *blob = (rsv_blob){ 0 };
}

static int write_blob(rsv_store *s, const char *name, const void *byte, size_t count)
{
    memory_blob *blob = find(s, name), fresh = { 0 };
    if (!blob) blob = create(s, name);
    if (!blob || add_part(s->context, &fresh, byte, count) != 0) {
        rsv_free(s->context, fresh.part);
        return ENOMEM;
    }
    drop_parts(s->context, blob, 0);
    rsv_free(s->context, blob->part);
    blob->part = fresh.part;
    blob->part_count = fresh.part_count;
    blob->part_capacity = fresh.part_capacity;
    return 0;
}

static int open_end(rsv_store *s, const char *name, size_t keep, int *end)
{
    memory_blob *blob = find(s, name);
    if (blob) drop_parts(s->context, blob, keep);
    if (!blob) blob = create(s, name);
    if (!blob) return ENOMEM;
    *end = (int)(blob - of(s)->blob);
    return 0;
}

static int append(rsv_store *s, int end, const void *byte, size_t count)
{
    return add_part(s->context, &of(s)->blob[end], byte, count);
}

static void close_end(rsv_store *s, int end) { (void)s, (void)end; }

static size_t bytes_of(const rsv_store *s)
{
    const memory_store *m = (const memory_store *)(const void *)s;
    size_t bytes = 0;
    for (size_t k = 0; k < m->blob_count; k++)
        for (size_t part = 0; part < m->blob[k].part_count; part++)
            bytes += m->blob[k].part[part].count;
    return bytes;
}

static void destroy(rsv_store *s)
{
    for (size_t k = 0; k < of(s)->blob_count; k++) {
        drop_parts(s->context, &of(s)->blob[k], 0);
        rsv_free(s->context, of(s)->blob[k].part);
    }
    rsv_free(s->context, of(s)->blob);
    rsv_free(s->context, s);
}

rsv_status rsv_store_memory(rsv_context *context, rsv_store **store)
{
    static const rsv_store_table table = { list, read_part, release, write_blob, open_end, append,
        close_end, bytes_of, destroy };
    memory_store *m = rsv_alloc(context, 1, sizeof *m);
    if (!m) return RSV_ERROR_MEMORY;
    m->store = (rsv_store){ &table, context, "update", "memory", false };
    *store = &m->store;
    return RSV_OK;
}
