/// Row records of a store.
#ifndef RSV_ROW_READER_H
#define RSV_ROW_READER_H

#include "row_record.h"
#include "store.h"

#define RSV_ROW_KEY_DIGITS 16 ///< in front of the names of all blobs that belong together

typedef struct rsv_row_reader {
    rsv_context *context;
    rsv_store *store;
    rsv_blob *known; ///< [node_count] records by node; empty = none
    size_t node_count;
    uint32_t ray_count;
    rsv_blob *blob; ///< [blob_count] in which they lie
    size_t blob_count, capacity;
} rsv_row_reader;

/// Lists the records in the blobs KEY-*.rows. Records that were cut off when their writer ended are dropped.
/// @param reader its other fields give the place and the number of rows
/// @param own name of one of them @param own_bytes out: size of its valid records
rsv_status rsv_row_reader_open(
    rsv_row_reader *reader, const char *key, const char *own, size_t *own_bytes);
/// @return the node's record; NULL if there is none, or another process has overwritten it since the reader was opened
const uint8_t *rsv_row_reader_find(const rsv_row_reader *reader, uint32_t node);
void rsv_row_reader_close(rsv_row_reader *reader);

#endif
