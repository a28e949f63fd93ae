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
static char *print_header(rsv_tensor_file *file, const rsv_tensor *const *order)
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

static void append(rsv_atomic_file *out, rsv_sha256 *hash, const void *data, size_t bytes)
{
    rsv_sha256_add(hash, data, bytes);
    rsv_atomic_file_append(out, data, bytes);
}

static rsv_status append_tensors(const rsv_tensor_file *file, const rsv_tensor *const *order,
    rsv_atomic_file *out, rsv_sha256 *hash)
{
    for (size_t k = 0; k < file->count; k++) {
        const uint8_t *data = order[k]->data;
        size_t left = rsv_tensor_length(order[k]) * rsv_tensor_type_bytes(order[k]->type);
        while (left > 0) {
            size_t part = left < BLOCK_BYTES ? left : BLOCK_BYTES;
            append(out, hash, data, part);
            data += part;
            left -= part;
            if (rsv_cancelled(file->context)) return rsv_progress(file->context, "write", 0);
        }
    }
    return RSV_OK;
}

/// Length, header with a checksum of zeros, arrays; then the checksum.
static rsv_status write_parts(
    rsv_tensor_file *file, const char *header, const rsv_tensor *const *order, rsv_atomic_file *out)
{
    rsv_status status;
    char digits[RSV_SHA256_DIGITS + 1];
    rsv_sha256 hash = rsv_sha256_begin();
    uint8_t length[8];
    for (int k = 0; k < 8; k++)
        length[k] = (uint8_t)((uint64_t)strlen(header) >> 8 * k);
    append(out, &hash, length, sizeof length);
    append(out, &hash, header, strlen(header));
    RSV_TRY(append_tensors(file, order, out, &hash));
    rsv_sha256_end(&hash, digits);
    const char *place = strstr(header, "\"" RSV_CHECKSUM_NOTE "\":\"");
    RSV_ASSERT(place);
    size_t offset = (size_t)(place - header) + strlen("\"" RSV_CHECKSUM_NOTE "\":\"");
    rsv_atomic_file_write_at(out, sizeof length + offset, digits, RSV_SHA256_DIGITS);
    status = rsv_atomic_file_commit(out);
cleanup:
    return status;
}

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
    rsv_atomic_file out = { .descriptor = -1 };
    char *header = NULL;
    const rsv_tensor **order = rsv_alloc(file->context, file->count, sizeof *order);
    if (!order) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_atomic_file_open(&out, file->path));
    RSV_TRY(add_checksum_note(file));
    for (size_t k = 0; k < file->count; k++)
        order[k] = &file->tensor[k];
    qsort(order, file->count, sizeof *order, compare_widths);
    header = print_header(file, order);
    if (!header) {
        status = rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory writing it", file->path);
        goto cleanup;
    }
    RSV_TRY(write_parts(file, header, order, &out));
cleanup:
    rsv_atomic_file_discard(&out);
    free(header);
    rsv_free(file->context, order);
    return status;
}
