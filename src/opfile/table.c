#include "table.h"

#include <string.h>

rsv_status rsv_write_table(rsv_tensor_file *file, const rsv_column *column, size_t column_count,
    const void *rows, size_t row_count, size_t stride)
{
    for (size_t c = 0; c < column_count; c++) {
        size_t bytes = column[c].width * rsv_tensor_type_bytes(column[c].type);
        uint8_t *data = rsv_alloc(file->context, row_count, bytes);
        for (size_t row = 0; data && row < row_count; row++)
            memcpy(
                data + row * bytes, (const uint8_t *)rows + row * stride + column[c].offset, bytes);
        rsv_status status =
            rsv_tensor_give(file, column[c].name, column[c].type, column[c].width, row_count, data);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

static bool is_below_bound(const rsv_column *column, const uint8_t *data, size_t count)
{
    for (size_t k = 0; column->bound && k < count; k++) {
        uint32_t value = data[k];
        if (column->type == RSV_TENSOR_U32) memcpy(&value, data + 4 * k, sizeof value);
        if (value >= column->bound) return false;
    }
    return true;
}

static rsv_status read_column(
    rsv_tensor_file *file, const rsv_column *column, uint8_t *rows, size_t row_count, size_t stride)
{
    rsv_status status;
    size_t bytes = column->width * rsv_tensor_type_bytes(column->type);
    uint8_t *data = NULL;
    RSV_TRY(
        rsv_tensor_exchange(file, column->name, column->type, column->width, &data, &row_count));
    if (!is_below_bound(column, data, row_count * column->width))
        RSV_TRY(rsv_tensor_fail(file, column->name, "is not below %u", column->bound));
    for (size_t row = 0; row < row_count; row++)
        memcpy(rows + row * stride + column->offset, data + row * bytes, bytes);
cleanup:
    rsv_free(file->context, data);
    return status;
}

rsv_status rsv_read_table(rsv_tensor_file *file, const rsv_column *column, size_t column_count,
    void *rows, size_t *row_count, size_t stride)
{
    const rsv_tensor *first = rsv_tensor_find(file, column[0].name);
    if (!first || first->rank == 0) return rsv_tensor_fail(file, column[0].name, "is missing");
    if (*row_count == RSV_ANY_COUNT) *row_count = first->shape[0];
    if (*row_count != first->shape[0])
        return rsv_tensor_fail(
            file, column[0].name, "has %zu rows where %zu belong", first->shape[0], *row_count);
    uint8_t *table = rsv_alloc(file->context, *row_count, stride);
    if (!table) return RSV_ERROR_MEMORY;
    *(void **)rows = table;
    for (size_t c = 0; c < column_count; c++) {
        rsv_status status = read_column(file, &column[c], table, *row_count, stride);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}
