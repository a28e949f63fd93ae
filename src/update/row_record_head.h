/// Layout of a row record (row_record.h): a head, followed by the arrays whose sizes it gives.
#ifndef RSV_ROW_RECORD_HEAD_H
#define RSV_ROW_RECORD_HEAD_H

#include "../core/core.h"

/// Followed by `rsv_row_part`, and by zeros up to a multiple of 8.
typedef struct rsv_row_record_head {
    uint32_t magic, node;
    uint32_t count, tinted_count, escape_count, tinted_escape_count;
    rsv_rgb emission;
    uint32_t ray_count;
    uint32_t index, valid; ///< of rsv_row_scratch
    uint64_t rays;
    uint64_t checksum; ///< of the record with 0 here
} rsv_row_record_head;

typedef enum rsv_row_part {
    RSV_ROW_COLUMN,
    RSV_ROW_TINTED_COLUMN,
    RSV_ROW_TINTED_WEIGHT,
    RSV_ROW_ESCAPE_WEIGHT,
    RSV_ROW_ESCAPE,
    RSV_ROW_TINTED_ESCAPE,
    RSV_ROW_KIND,
    RSV_ROW_PARTS
} rsv_row_part;

/// Where the parts of a record begin, and its end: larger items first, so that all are aligned.
typedef struct rsv_row_record_layout {
    size_t begin[RSV_ROW_PARTS + 1];
} rsv_row_record_layout;

/// @param head whose counts are no more than rows can have rays
rsv_row_record_layout rsv_row_record_layout_of(const rsv_row_record_head *head);

/// Guards against cut-off writes and damage, not against malice. @param bytes [count] of the record
uint64_t rsv_row_record_checksum(const uint8_t *bytes, size_t count);

#endif
