#include "gltf_archive.h"

#include "../core/core.h"

#include <string.h>

enum { HEADER = 12, CHUNK_HEADER = 8, FILE_HEADER = 8 };

// ---- packing --------------------------------------------------------------------------------------

/// Written twice: once to find out how long it becomes.
typedef struct packer {
    uint8_t *bytes; ///< NULL = only counted
    size_t count;
} packer;

static void put(packer *p, const void *data, size_t count)
{
    if (p->bytes && count) memcpy(p->bytes + p->count, data, count);
    p->count += count;
}

static void put_number(packer *p, size_t value)
{
    const uint8_t little_endian[4] = { value & 255, value >> 8 & 255, value >> 16 & 255,
        value >> 24 & 255 };
    put(p, little_endian, 4);
}

static void pad(packer *p, char with)
{
    while (p->count % 4)
        put(p, &with, 1);
}

static size_t padded(size_t count) { return (count + 3) / 4 * 4; }

static void put_chunk(packer *p, uint32_t type, const void *data, size_t count)
{
    put_number(p, padded(count));
    put_number(p, type);
    put(p, data, count);
    pad(p, type == RSV_GLB_JSON ? ' ' : 0);
}

/// Adds a file beside the document. Data within the document need not be added.
static void put_file(packer *p, const char *uri, const uint8_t *data, size_t count)
{
    if (!uri || !data || strncmp(uri, "data:", 5) == 0) return;
    size_t name = strlen(uri) + 1;
    put_number(p, padded(FILE_HEADER + name + count));
    put_number(p, RSV_GLB_FILE);
    put_number(p, name);
    put_number(p, count);
    put(p, uri, name);
    put(p, data, count);
    pad(p, 0);
}

static void put_all(packer *p, const rsv_gltf_document *d, size_t total)
{
    put_number(p, RSV_GLB_MAGIC);
    put_number(p, 2);
    put_number(p, total);
    put_chunk(p, RSV_GLB_JSON, d->text, d->text_bytes);
    if (d->buffer_count && !d->buffer[0].uri && d->buffer[0].data)
        put_chunk(p, RSV_GLB_BINARY, d->buffer[0].data, d->buffer[0].size);
    for (size_t k = 0; k < d->buffer_count; k++)
        put_file(p, d->buffer[k].uri, d->buffer[k].data, d->buffer[k].size);
    for (size_t k = 0; k < d->image_count; k++)
        put_file(p, d->image[k].uri, d->image[k].bytes, d->image[k].size);
    for (size_t k = 0; k < d->luminaire_count; k++)
        put_file(p, d->luminaire[k].uri, d->luminaire[k].bytes, d->luminaire[k].size);
}

rsv_status rsv_gltf_archive_pack(
    rsv_context *context, const rsv_gltf_document *document, uint8_t **bytes, size_t *count)
{
    packer p = { 0 };
    put_all(&p, document, 0);
    if (p.count > UINT32_MAX)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "it needs %zu bytes, more than 4 GiB", p.count);
    *count = p.count;
    p = (packer){ .bytes = rsv_alloc(context, *count, 1) };
    if (!p.bytes) return RSV_ERROR_MEMORY;
    put_all(&p, document, *count);
    *bytes = p.bytes;
    return RSV_OK;
}

// ---- reading --------------------------------------------------------------------------------------

static uint32_t number_at(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/// Reads the contents of a chunk of type "FILE"; false for other chunks.
static bool open_file(rsv_gltf_chunk *chunk)
{
    if (chunk->size < FILE_HEADER) return false;
    size_t name = number_at(chunk->data), size = number_at(chunk->data + 4);
    const uint8_t *text = chunk->data + FILE_HEADER;
    if (name < 1 || name + size > chunk->size - FILE_HEADER || text[name - 1]) return false;
    chunk->uri = (const char *)text;
    chunk->data = text + name;
    chunk->size = size;
    return true;
}

bool rsv_gltf_archive_next(const uint8_t *archive, size_t count, size_t *at, rsv_gltf_chunk *chunk)
{
    if (*at == 0) {
        if (count < HEADER || number_at(archive) != RSV_GLB_MAGIC ||
            number_at(archive + 8) != count)
            return false;
        *at = HEADER;
    }
    if (count - *at < CHUNK_HEADER) return false;
    size_t size = number_at(archive + *at);
    if (size > count - *at - CHUNK_HEADER) return false;
    *chunk = (rsv_gltf_chunk){
        .type = number_at(archive + *at + 4), .data = archive + *at + CHUNK_HEADER, .size = size
    };
    if (chunk->type == RSV_GLB_FILE && !open_file(chunk)) return false;
    *at += CHUNK_HEADER + size;
    return true;
}
