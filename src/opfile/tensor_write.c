#include "../core/team.h"
#include "../io/atomic_file.h"
#include "sha256.h"
#include "tensor_file.h"

#include <stdlib.h>
#include <string.h>

#define HEADER_ALIGNMENT 8
#define BLOCK_BYTES ((size_t)1 << 24)

rsv_status rsv_tensor_file_begin(rsv_context *context, const char *path, rsv_tensor_file *file)
{
    *file = (rsv_tensor_file){ .context = context, .path = path };
    file->notes = cJSON_CreateObject();
    return file->notes ? RSV_OK : rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", path);
}

rsv_status rsv_note_set(rsv_tensor_file *file, const char *name, const char *text)
{
    if (text && cJSON_AddStringToObject(file->notes, name, text)) return RSV_OK;
    return rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", file->path);
}

/// Wide numbers first: so every array starts at a multiple of the size of its numbers, without gaps, which the
/// layout does not allow.
static int compare_widths(const void *left, const void *right)
{
    const rsv_tensor *const *a = left, *const *b = right;
    size_t x = rsv_tensor_type_bytes((*a)->type), y = rsv_tensor_type_bytes((*b)->type);
    if (x != y) return x < y ? 1 : -1;
    return (*a > *b) - (*a < *b);
}

static bool add_entry(cJSON *root, const rsv_tensor *tensor, size_t begin, size_t end)
{
    cJSON *entry = cJSON_AddObjectToObject(root, tensor->name);
    bool added = cJSON_AddStringToObject(entry, "dtype", rsv_tensor_type_name(tensor->type));
    cJSON *shape = cJSON_AddArrayToObject(entry, "shape");
    for (uint32_t k = 0; k < tensor->rank; k++)
        added = added && cJSON_AddItemToArray(shape, cJSON_CreateNumber((double)tensor->shape[k]));
    cJSON *offsets = cJSON_AddArrayToObject(entry, "data_offsets");
    added = added && cJSON_AddItemToArray(offsets, cJSON_CreateNumber((double)begin));
    return added && cJSON_AddItemToArray(offsets, cJSON_CreateNumber((double)end));
}

/// The header, padded with spaces; free with free(). NULL on exhaustion.
static char *print_header(rsv_tensor_file *file, const rsv_tensor **order)
{
    char *padded = NULL, *text = NULL;
    cJSON *root = cJSON_CreateObject();
    bool complete = root && cJSON_AddItemReferenceToObject(root, "__metadata__", file->notes);
    size_t begin = 0;
    for (size_t k = 0; complete && k < file->count; k++) {
        size_t bytes = rsv_tensor_length(order[k]) * rsv_tensor_type_bytes(order[k]->type);
        complete = add_entry(root, order[k], begin, begin + bytes);
        begin += bytes;
    }
    if (complete) text = cJSON_PrintUnformatted(root);
    if (text) {
        size_t length = strlen(text);
        size_t full = (length + HEADER_ALIGNMENT - 1) / HEADER_ALIGNMENT * HEADER_ALIGNMENT;
        padded = malloc(full + 1);
        if (padded) {
            memcpy(padded, text, length);
            memset(padded + length, ' ', full - length);
            padded[full] = '\0';
        }
    }
    cJSON_free(text);
    cJSON_Delete(root);
    return padded;
}

#define CHECKSUM_START "\"" RSV_CHECKSUM_NOTE "\":\""
#define LENGTH_BYTES 8

/// A file in the making: its header, and its arrays in their order.
typedef struct layout {
    const rsv_tensor_file *file;
    const char *header;
    const rsv_tensor **order; ///< [file->count]
} layout;

static void append(rsv_atomic_file *out, rsv_sha256 *hash, const void *data, size_t bytes)
{
    rsv_sha256_add(hash, data, bytes);
    rsv_atomic_file_append(out, data, bytes);
}

static size_t tensor_bytes(const rsv_tensor *tensor)
{
    return rsv_tensor_length(tensor) * rsv_tensor_type_bytes(tensor->type);
}

static void encode_length(const char *header, uint8_t length[LENGTH_BYTES])
{
    for (int k = 0; k < LENGTH_BYTES; k++)
        length[k] = (uint8_t)((uint64_t)strlen(header) >> 8 * k);
}

static void write_checksum(const layout *l, rsv_atomic_file *out, rsv_sha256 *hash)
{
    char digits[RSV_SHA256_DIGITS + 1];
    rsv_sha256_end(hash, digits);
    const char *place = strstr(l->header, CHECKSUM_START);
    RSV_ASSERT(place);
    size_t offset = (size_t)(place - l->header) + strlen(CHECKSUM_START);
    rsv_atomic_file_write_at(out, LENGTH_BYTES + offset, digits, RSV_SHA256_DIGITS);
}

static rsv_status append_tensors(const layout *l, rsv_atomic_file *out, rsv_sha256 *hash)
{
    for (size_t k = 0; k < l->file->count; k++) {
        const uint8_t *data = l->order[k]->data;
        size_t left = tensor_bytes(l->order[k]);
        while (left > 0) {
            size_t part = left < BLOCK_BYTES ? left : BLOCK_BYTES;
            append(out, hash, data, part);
            data += part;
            left -= part;
            if (rsv_cancelled(l->file->context)) return rsv_progress(l->file->context, "write", 0);
        }
    }
    return RSV_OK;
}

/// Length, header with a checksum of zeros, arrays; then the checksum.
static rsv_status write_alone(const layout *l)
{
    rsv_status status;
    rsv_sha256 hash = rsv_sha256_begin();
    uint8_t length[LENGTH_BYTES];
    rsv_atomic_file out = { .descriptor = -1 };
    RSV_TRY(rsv_atomic_file_open(&out, l->file->path));
    encode_length(l->header, length);
    append(&out, &hash, length, sizeof length);
    append(&out, &hash, l->header, strlen(l->header));
    RSV_TRY(append_tensors(l, &out, &hash));
    write_checksum(l, &out, &hash);
    status = rsv_atomic_file_commit(&out);
cleanup:
    rsv_atomic_file_discard(&out);
    return status;
}

// ---- several processes, one file -----------------------------------------------------------------

/// The rows that are here, those that follow each other in one piece.
static void write_rows(const rsv_tensor *t, uint64_t offset, rsv_atomic_file *out)
{
    size_t bytes = rsv_tensor_type_bytes(t->type) * (t->rank > 1 ? t->shape[1] : 1);
    const uint8_t *data = t->data;
    if (t->own_begin[t->row_count] == 0) return; // of none of these rows there is anything here
    for (size_t row = 0; row < t->row_count;) {
        size_t first = row, from = t->own_begin[row];
        // a row of another process ends the piece, unless it is empty
        while (row < t->row_count && t->own_begin[row + 1] - t->own_begin[row] ==
                                         t->whole_begin[row + 1] - t->whole_begin[row])
            row++;
        rsv_atomic_file_write_at(out, offset + t->whole_begin[first] * bytes, data + from * bytes,
            (t->own_begin[row] - from) * bytes);
        while (row < t->row_count && t->own_begin[row + 1] == t->own_begin[row])
            row++;
    }
}

/// Arrays that all processes have are written by turns.
static void write_part(const layout *l, rsv_team_place place, rsv_atomic_file *out)
{
    uint8_t length[LENGTH_BYTES];
    uint64_t offset = LENGTH_BYTES + strlen(l->header);
    encode_length(l->header, length);
    if (place.rank == 0) {
        rsv_atomic_file_append(out, length, sizeof length);
        rsv_atomic_file_append(out, l->header, strlen(l->header));
    }
    for (size_t k = 0; k < l->file->count; k++) {
        const rsv_tensor *t = l->order[k];
        if (t->whole_begin)
            write_rows(t, offset, out);
        else if (k % place.size == place.rank)
            rsv_atomic_file_write_at(out, offset, t->data, tensor_bytes(t));
        offset += tensor_bytes(t);
    }
}

/// The checksum covers the whole file: the first process reads what the others wrote.
static rsv_status add_checksum(const layout *l, rsv_atomic_file *out)
{
    rsv_status status = RSV_OK;
    rsv_context *context = l->file->context;
    rsv_sha256 hash = rsv_sha256_begin();
    uint64_t end = LENGTH_BYTES + strlen(l->header);
    for (size_t k = 0; k < l->file->count; k++)
        end += tensor_bytes(l->order[k]);
    uint8_t *block = rsv_alloc(context, BLOCK_BYTES, 1);
    if (!block) return RSV_ERROR_MEMORY;
    for (uint64_t at = 0; at < end && status == RSV_OK && !out->error; at += BLOCK_BYTES) {
        size_t bytes = end - at < BLOCK_BYTES ? (size_t)(end - at) : BLOCK_BYTES;
        rsv_atomic_file_read_at(out, at, block, bytes);
        rsv_sha256_add(&hash, block, bytes);
        status = rsv_progress(context, "write", (double)at / (double)end);
    }
    rsv_free(context, block);
    if (status == RSV_OK) write_checksum(l, out, &hash);
    return status == RSV_OK ? rsv_atomic_file_commit(out) : status;
}

static rsv_status write_together(const layout *l, rsv_team_place place)
{
    rsv_status status = RSV_OK;
    rsv_context *context = l->file->context;
    rsv_atomic_file out = { .descriptor = -1 };
    if (place.rank == 0) status = rsv_atomic_file_open(&out, l->file->path);
    RSV_TRY(rsv_team_meet(context, status));
    char temporary[RSV_PATH_BYTES];
    memcpy(temporary, out.temporary, sizeof temporary);
    rsv_team_copy(context, 0, temporary, sizeof temporary);
    if (place.rank > 0) status = rsv_atomic_file_join(&out, temporary);
    RSV_TRY(rsv_team_meet(context, status));
    write_part(l, place, &out);
    if (place.rank > 0) status = rsv_atomic_file_close(&out);
    RSV_TRY(rsv_team_meet(context, status));
    if (place.rank == 0) status = add_checksum(l, &out);
    status = rsv_team_meet(context, status);
cleanup:
    rsv_atomic_file_discard(&out);
    return status;
}

// ---- all -----------------------------------------------------------------------------------------

/// The checksum comes first, so that no other note can look like it.
static rsv_status add_checksum_note(rsv_tensor_file *file)
{
    char zeros[RSV_SHA256_DIGITS + 1];
    memset(zeros, '0', RSV_SHA256_DIGITS);
    zeros[RSV_SHA256_DIGITS] = '\0';
    cJSON *note = cJSON_CreateString(zeros), *named = cJSON_CreateObject();
    bool added = note && named && cJSON_AddItemToObject(named, RSV_CHECKSUM_NOTE, note);
    if (added) note = cJSON_DetachItemFromObject(named, RSV_CHECKSUM_NOTE); // now has its name
    cJSON_Delete(named);
    added = added && cJSON_InsertItemInArray(file->notes, 0, note);
    return added ? RSV_OK : rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", file->path);
}

rsv_status rsv_tensor_file_write(rsv_tensor_file *file)
{
    rsv_status status;
    rsv_team_place place = rsv_team_place_of(file->context);
    char *header = NULL;
    const rsv_tensor **order = rsv_alloc(file->context, file->count, sizeof *order);
    if (!order) return RSV_ERROR_MEMORY;
    RSV_TRY(add_checksum_note(file));
    for (size_t k = 0; k < file->count; k++)
        order[k] = &file->tensor[k];
    qsort(order, file->count, sizeof *order, compare_widths);
    header = print_header(file, order);
    if (!header) {
        status = rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", file->path);
        goto cleanup;
    }
    const layout l = { file, header, order };
    status = place.size > 1 ? write_together(&l, place) : write_alone(&l);
cleanup:
    free(header);
    rsv_free(file->context, order);
    return status;
}

void rsv_tensor_file_digest(const rsv_tensor_file *file, char *digits)
{
    rsv_sha256 hash = rsv_sha256_begin();
    for (const cJSON *note = file->notes->child; note; note = note->next)
        rsv_sha256_add(&hash, note->valuestring, strlen(note->valuestring));
    for (size_t k = 0; k < file->count; k++) {
        const rsv_tensor *t = &file->tensor[k];
        rsv_sha256_add(&hash, t->name, strlen(t->name));
        rsv_sha256_add(&hash, t->data, rsv_tensor_length(t) * rsv_tensor_type_bytes(t->type));
    }
    rsv_sha256_end(&hash, digits);
}
