/// Arrays of structs as tensors, one per field.
#ifndef RSV_TABLE_H
#define RSV_TABLE_H

#include "tensor_file.h"

typedef struct rsv_column {
    const char *name;
    rsv_tensor_type type;
    size_t width;   ///< numbers per row
    size_t offset;  ///< in the struct
    uint32_t bound; ///< integers are below it; floats are not looked at
} rsv_column;

// clang-format off
#define RSV_FLOATS(type, field, width) { #field, RSV_TENSOR_F32, width, offsetof(type, field), 0 }
#define RSV_CHOICE(type, field, bound) { #field, RSV_TENSOR_U32, 1, offsetof(type, field), bound }
#define RSV_FLAG(type, field) { #field, RSV_TENSOR_U8, 1, offsetof(type, field), 2 }
// clang-format on

/// @param stride bytes of a struct
rsv_status rsv_write_table(rsv_tensor_file *file, const rsv_column *column, size_t column_count,
    const void *rows, size_t row_count, size_t stride);
/// @param rows out: allocated, zero except for the columns @param row_count as in rsv_tensor_exchange
rsv_status rsv_read_table(rsv_tensor_file *file, const rsv_column *column, size_t column_count,
    void *rows, size_t *row_count, size_t stride);

#endif
