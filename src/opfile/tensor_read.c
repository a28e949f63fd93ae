#include "sha256.h"
#include "tensor_file.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define LENGTH_BYTES 8
/// Headers are a few kilobytes. Parsing larger ones would only help to exhaust memory.
#define LARGEST_HEADER ((uint64_t)1 << 26)

static rsv_status map_file(rsv_tensor_file *file)
{
    struct stat info;
    rsv_status status = RSV_OK;
    int descriptor = open(file->path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0 || fstat(descriptor, &info) != 0) {
        status = rsv_fail(RSV_ERROR_IO, "cannot read '%s': %s", file->path, strerror(errno));
        goto cleanup;
    }
    if (!S_ISREG(info.st_mode) || info.st_size < LENGTH_BYTES) {
        status = rsv_fail(RSV_ERROR_FORMAT,
            "%s: it is too short to be an operator file; solve the scene again", file->path);
        goto cleanup;
    }
    void *map = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (map == MAP_FAILED) {
        status = rsv_fail(RSV_ERROR_IO, "cannot map '%s': %s", file->path, strerror(errno));
        goto cleanup;
    }
    file->map = map;
    file->map_bytes = (size_t)info.st_size;
cleanup:
    if (descriptor >= 0) close(descriptor);
    return status;
}

/// Whole number of a JSON item; false if it is not one, or too large for a double to be exact.
static bool read_count(const cJSON *item, uint64_t *count)
{
    if (!cJSON_IsNumber(item)) return false;
    double value = item->valuedouble;
    if (!(value >= 0 && value <= 0x1p53) || value != floor(value)) return false;
    *count = (uint64_t)value;
    return true;
}

static bool read_type(const cJSON *item, rsv_tensor_type *type)
{
    const char *name = cJSON_GetStringValue(item);
    for (int k = RSV_TENSOR_U8; name && k <= RSV_TENSOR_F32; k++)
        if (strcmp(name, rsv_tensor_type_name((rsv_tensor_type)k)) == 0) {
            *type = (rsv_tensor_type)k;
            return true;
        }
    return false;
}

/// Shape of an entry; false if there are too many dimensions or numbers.
static bool read_shape(const cJSON *item, rsv_tensor *tensor)
{
    size_t numbers = 1;
    const cJSON *dimension;
    if (!cJSON_IsArray(item)) return false;
    cJSON_ArrayForEach(dimension, item)
    {
        uint64_t count;
        if (tensor->rank == RSV_TENSOR_RANK || !read_count(dimension, &count)) return false;
        if (count && numbers > SIZE_MAX / 16 / count) return false;
        numbers *= count;
        tensor->shape[tensor->rank++] = count;
    }
    return true;
}

static rsv_status add_tensor(rsv_tensor_file *file, const cJSON *entry, const uint8_t *data,
    uint64_t data_bytes, uint64_t *covered)
{
    rsv_tensor tensor = { 0 };
    uint64_t begin, end;
    const cJSON *offsets = cJSON_GetObjectItemCaseSensitive(entry, "data_offsets");
    bool sound = read_type(cJSON_GetObjectItemCaseSensitive(entry, "dtype"), &tensor.type) &&
                 read_shape(cJSON_GetObjectItemCaseSensitive(entry, "shape"), &tensor) &&
                 cJSON_GetArraySize(offsets) == 2 &&
                 read_count(cJSON_GetArrayItem(offsets, 0), &begin) &&
                 read_count(cJSON_GetArrayItem(offsets, 1), &end);
    size_t size = rsv_tensor_type_bytes(tensor.type);
    if (!sound || begin > end || end > data_bytes || begin % size != 0 ||
        end - begin != rsv_tensor_length(&tensor) * size)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: the header describes tensor '%.80s' wrongly (type, shape or position): the file is cut off or "
            "not an operator file; `resolvent solve` writes those",
            file->path, entry->string);
    *covered += end - begin;
    tensor.data = data + begin;
    rsv_status status = rsv_grow(file->context, (void **)&file->tensor, &file->capacity,
        file->count + 1, sizeof *file->tensor);
    if (status != RSV_OK) return status;
    tensor.name = rsv_copy_string(file->context, entry->string);
    file->tensor[file->count] = tensor;
    file->count += tensor.name != NULL;
    return tensor.name ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status read_entries(
    rsv_tensor_file *file, cJSON *root, const uint8_t *data, uint64_t data_bytes)
{
    uint64_t covered = 0;
    const cJSON *entry;
    cJSON_ArrayForEach(entry, root)
    {
        if (strcmp(entry->string, "__metadata__") == 0) continue;
        rsv_status status = add_tensor(file, entry, data, data_bytes, &covered);
        if (status != RSV_OK) return status;
    }
    if (covered != data_bytes)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: its tensors hold %llu bytes, but %llu follow the header: the file is cut off or "
            "not an operator file; solve the scene again",
            file->path, (unsigned long long)covered, (unsigned long long)data_bytes);
    return RSV_OK;
}

static rsv_status read_header(rsv_tensor_file *file)
{
    uint64_t length = 0, available = file->map_bytes - LENGTH_BYTES;
    for (int k = 0; k < LENGTH_BYTES; k++)
        length |= (uint64_t)file->map[k] << 8 * k;
    if (length > available || length > LARGEST_HEADER)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: a header of %llu bytes in a file of %zu: it is cut off or not an operator file; solve the "
            "scene again",
            file->path, (unsigned long long)length, file->map_bytes);
    const char *text = (const char *)file->map + LENGTH_BYTES;
    cJSON *root = cJSON_ParseWithLength(text, length);
    if (!cJSON_IsObject(root)) {
        cJSON_Delete(root);
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: its header is not a JSON object: it is damaged or not an operator file",
            file->path);
    }
    file->notes = cJSON_DetachItemFromObjectCaseSensitive(root, "__metadata__");
    rsv_status status =
        read_entries(file, root, file->map + LENGTH_BYTES + length, available - length);
    cJSON_Delete(root);
    return status;
}

rsv_status rsv_tensor_file_open(rsv_context *context, const char *path, rsv_tensor_file *file)
{
    *file = (rsv_tensor_file){ .context = context, .path = path, .reading = true };
    rsv_status status;
    RSV_TRY(map_file(file));
    RSV_TRY(read_header(file));
cleanup:
    if (status != RSV_OK) rsv_tensor_file_end(file);
    return status;
}

const char *rsv_note_get(const rsv_tensor_file *file, const char *name)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(file->notes, name));
}

/// Where the checksum's digits stand; NULL if nowhere.
static const uint8_t *find_digits(const rsv_tensor_file *file, const char *digits)
{
    const uint8_t *header = file->map + LENGTH_BYTES;
    size_t reach = file->map_bytes - LENGTH_BYTES;
    return memmem(
        header, reach < LARGEST_HEADER ? reach : LARGEST_HEADER, digits, RSV_SHA256_DIGITS);
}

rsv_status rsv_tensor_file_verify(const rsv_tensor_file *file)
{
    char zeros[RSV_SHA256_DIGITS], found[RSV_SHA256_DIGITS + 1];
    const char *stated = rsv_note_get(file, RSV_CHECKSUM_NOTE);
    const uint8_t *place =
        stated && strlen(stated) == RSV_SHA256_DIGITS ? find_digits(file, stated) : NULL;
    if (!place)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: it lacks its checksum (note '" RSV_CHECKSUM_NOTE "'); solve the scene again",
            file->path);
    memset(zeros, '0', sizeof zeros);
    rsv_sha256 hash = rsv_sha256_begin();
    rsv_sha256_add(&hash, file->map, (size_t)(place - file->map));
    rsv_sha256_add(&hash, zeros, sizeof zeros);
    const uint8_t *rest = place + RSV_SHA256_DIGITS;
    rsv_sha256_add(&hash, rest, (size_t)(file->map + file->map_bytes - rest));
    rsv_sha256_end(&hash, found);
    if (strcmp(stated, found) == 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "%s: its checksum does not match its content: it was damaged or changed; solve the scene "
        "again",
        file->path);
}
