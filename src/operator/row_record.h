/// Rows of G as bytes: what tracing found, so that it need not be traced again.
#ifndef RSV_ROW_RECORD_H
#define RSV_ROW_RECORD_H

#include "row_tracer.h"

/// Records on their way to a file.
typedef struct rsv_row_block {
    uint8_t *byte;
    size_t count, capacity;
} rsv_row_block;

/// Appends a row to a block. @param ray_count of each row @param rays that it took, chains included
rsv_status rsv_row_record_put(rsv_context *context, uint32_t node, uint32_t ray_count,
    const rsv_row_scratch *scratch, uint64_t rays, rsv_row_block *block);

/// @param bytes [left], at a multiple of 8
/// @param node out: whose row it is
/// @return bytes up to the next one; 0 if here is none that is whole and of such rows
size_t rsv_row_record_bytes(
    const uint8_t *bytes, size_t left, size_t node_count, uint32_t ray_count, uint32_t *node);

/// Whether a record is unharmed. @param count its bytes
bool rsv_row_record_is_sound(const uint8_t *bytes, size_t count, size_t node_count);

/// Fills `scratch` as tracing the row did. @param record one that was checked
void rsv_row_record_take(const uint8_t *record, uint32_t ray_count, rsv_row_scratch *scratch);

/// What each of its rays found, for rsv_row_trace_anew. @param record one that was checked
rsv_row_past rsv_row_record_past(const uint8_t *record);

#endif
