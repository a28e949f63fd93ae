/// Shared by writing and reading: the exchange of arrays, and checks.
#include "tensor_file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

static const struct {
    const char *name;
    size_t bytes;
} types[] = { [RSV_TENSOR_U8] = { "U8", 1 },
    [RSV_TENSOR_U16] = { "U16", 2 },
    [RSV_TENSOR_U32] = { "U32", 4 },
    [RSV_TENSOR_U64] = { "U64", 8 },
    [RSV_TENSOR_F32] = { "F32", 4 } };

size_t rsv_tensor_type_bytes(rsv_tensor_type type) { return types[type].bytes; }
const char *rsv_tensor_type_name(rsv_tensor_type type) { return types[type].name; }

size_t rsv_tensor_length(const rsv_tensor *tensor)
{
    size_t length = 1;
    for (uint32_t k = 0; k < tensor->rank; k++)
        length *= tensor->shape[k];
    return length;
}

void rsv_tensor_file_end(rsv_tensor_file *file)
{
    if (file->map) munmap(file->map, file->map_bytes);
    cJSON_Delete(file->notes);
    for (size_t k = 0; k < file->count; k++) {
        rsv_free(file->context, file->tensor[k].name);
        rsv_free(file->context, file->tensor[k].owned);
    }
    rsv_free(file->context, file->tensor);
    *file = (rsv_tensor_file){ 0 };
}

void rsv_tensor_prefix(rsv_tensor_file *file, const char *prefix)
{
    snprintf(file->prefix, sizeof file->prefix, "%s", prefix ? prefix : "");
}

/// Long enough for a prefix and the name of a light.
#define NAME_BYTES 512

static void full_name(const rsv_tensor_file *file, const char *name, char *full)
{
    snprintf(full, NAME_BYTES, "%s%s", file->prefix, name);
}

rsv_status rsv_tensor_fail(const rsv_tensor_file *file, const char *name, const char *format, ...)
{
    char what[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return rsv_fail(RSV_ERROR_FORMAT, "%s: tensor '%s%s' %s; solve the scene again", file->path,
        file->prefix, name, what);
}

const rsv_tensor *rsv_tensor_find(const rsv_tensor_file *file, const char *name)
{
    char full[NAME_BYTES];
    full_name(file, name, full);
    for (size_t k = 0; k < file->count; k++)
        if (strcmp(file->tensor[k].name, full) == 0) return &file->tensor[k];
    return NULL;
}

rsv_status rsv_tensor_add(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    uint32_t rank, const size_t *shape, const void *data)
{
    char full[NAME_BYTES];
    rsv_tensor tensor = { .type = type, .rank = rank, .data = data };
    memcpy(tensor.shape, shape, rank * sizeof *shape);
    rsv_status status = rsv_grow(file->context, (void **)&file->tensor, &file->capacity,
        file->count + 1, sizeof *file->tensor);
    if (status != RSV_OK) return status;
    full_name(file, name, full);
    tensor.name = rsv_copy_string(file->context, full);
    if (!tensor.name) return RSV_ERROR_MEMORY;
    file->tensor[file->count++] = tensor;
    return RSV_OK;
}

rsv_status rsv_tensor_give(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    size_t width, size_t count, void *data)
{
    const size_t shape[2] = { count, width };
    rsv_status status =
        data ? rsv_tensor_add(file, name, type, width > 1 ? 2 : 1, shape, data) : RSV_ERROR_MEMORY;
    if (status == RSV_OK)
        file->tensor[file->count - 1].owned = data;
    else
        rsv_free(file->context, data);
    return status;
}

void rsv_tensor_divide(
    rsv_tensor_file *file, size_t row_count, const size_t *own, const size_t *whole)
{
    rsv_tensor *tensor = &file->tensor[file->count - 1];
    tensor->row_count = row_count;
    tensor->own_begin = own;
    tensor->whole_begin = whole;
}

/// @param count required number of rows, or RSV_ANY_COUNT
static rsv_status check_shape(const rsv_tensor_file *file, const rsv_tensor *tensor,
    const char *name, rsv_tensor_type type, size_t width, size_t count)
{
    size_t rows = tensor->rank ? tensor->shape[0] : 0;
    bool shaped = width > 1 ? tensor->rank == 2 && tensor->shape[1] == width : tensor->rank == 1;
    if (tensor->type != type || !shaped)
        return rsv_tensor_fail(file, name, "is not of type %s with %zu numbers a row",
            rsv_tensor_type_name(type), width);
    if (count != RSV_ANY_COUNT && count != rows)
        return rsv_tensor_fail(file, name, "has %zu rows where %zu belong", rows, count);
    return RSV_OK;
}

static rsv_status copy_rows(
    rsv_tensor_file *file, const rsv_tensor *tensor, size_t width, void **array, size_t *count)
{
    size_t rows = tensor->rank ? tensor->shape[0] : 0;
    size_t row_bytes = width * rsv_tensor_type_bytes(tensor->type);
    void *copy = rsv_alloc(file->context, rows, row_bytes);
    if (!copy) return RSV_ERROR_MEMORY;
    if (rows) memcpy(copy, tensor->data, rows * row_bytes);
    *array = copy;
    *count = rows;
    return RSV_OK;
}

static rsv_status borrow(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    size_t width, const void *array, size_t count)
{
    const size_t shape[2] = { count, width };
    return rsv_tensor_add(file, name, type, width > 1 ? 2 : 1, shape, array);
}

rsv_status rsv_tensor_exchange_optional(rsv_tensor_file *file, const char *name,
    rsv_tensor_type type, size_t width, void *array, size_t *count)
{
    void **pointer = array;
    if (file->reading) {
        const rsv_tensor *tensor = rsv_tensor_find(file, name);
        if (!tensor) return RSV_OK;
        rsv_status status = check_shape(file, tensor, name, type, width, *count);
        return status == RSV_OK ? copy_rows(file, tensor, width, pointer, count) : status;
    }
    return *pointer ? borrow(file, name, type, width, *pointer, *count) : RSV_OK;
}

rsv_status rsv_tensor_exchange(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    size_t width, void *array, size_t *count)
{
    if (file->reading && !rsv_tensor_find(file, name))
        return rsv_tensor_fail(file, name, "is missing");
    if (!file->reading) return borrow(file, name, type, width, *(void **)array, *count);
    return rsv_tensor_exchange_optional(file, name, type, width, array, count);
}

rsv_status rsv_check_indices(const rsv_tensor_file *file, const char *name, const uint32_t *index,
    size_t count, size_t bound)
{
    for (size_t k = 0; k < count; k++)
        if (index[k] >= bound)
            return rsv_tensor_fail(
                file, name, "refers to number %u where there are %zu", index[k], bound);
    return RSV_OK;
}

rsv_status rsv_check_rows(
    const rsv_tensor_file *file, const char *name, const size_t *begin, size_t rows, size_t entries)
{
    bool sound = begin[0] == 0 && begin[rows] == entries;
    for (size_t row = 0; sound && row < rows; row++)
        sound = begin[row] <= begin[row + 1];
    return sound ? RSV_OK
                 : rsv_tensor_fail(
                       file, name, "does not divide %zu entries into %zu rows", entries, rows);
}

/// Sums of products with shares stay finite.
#define LARGEST_NUMBER 1e30f

rsv_status rsv_check_numbers(
    const rsv_tensor_file *file, const char *name, const float *number, size_t count, float least)
{
    for (size_t k = 0; k < count; k++)
        if (!(fabsf(number[k]) <= LARGEST_NUMBER && number[k] >= least))
            return rsv_tensor_fail(
                file, name, "has the invalid value %g at index %zu", number[k], k);
    return RSV_OK;
}
