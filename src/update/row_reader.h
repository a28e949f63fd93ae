/// Files of row records, mapped into memory.
#ifndef RSV_ROW_READER_H
#define RSV_ROW_READER_H

#include "row_record.h"

#define RSV_ROW_PATH_BYTES 4096
#define RSV_ROW_KEY_DIGITS 16 ///< in front of the names of all files that belong together

typedef struct rsv_mapped_file {
    uint8_t *byte;
    size_t count;
} rsv_mapped_file;

typedef struct rsv_row_reader {
    rsv_context *context;
    const uint8_t **known; ///< [node_count] records by node; NULL = none
    size_t node_count;
    uint32_t ray_count;
    rsv_mapped_file *file;
    size_t file_count, capacity;
} rsv_row_reader;

/// Notes what the files FOLDER/KEY-*.rows hold; records cut off by the end of their writer are dropped.
/// @param own path of one of them @param own_bytes out: of the sound records that it has
rsv_status rsv_row_reader_open(rsv_context *context, const char *folder, const char *key,
    size_t node_count, uint32_t ray_count, const char *own, size_t *own_bytes,
    rsv_row_reader *files);
/// @return the node's record, or NULL: there is none, or somebody else has written over it since the files were opened
const uint8_t *rsv_row_reader_find(const rsv_row_reader *files, uint32_t node);
void rsv_row_reader_close(rsv_row_reader *files);

#endif
