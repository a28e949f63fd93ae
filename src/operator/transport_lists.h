/// Rows as lists, for files and devices: they keep what is listed without knowing what it is.
#ifndef RSV_TRANSPORT_LISTS_H
#define RSV_TRANSPORT_LISTS_H

#include "transport.h"

/// Entries row by row: columns, or bins that rays escaped to.
typedef struct rsv_transport_list {
    const char *name;
    size_t **begin; ///< address of [row_count + 1]
    uint32_t **column;
    uint16_t **bin;   ///< of these two, the other one is NULL
    rsv_rgb **weight; ///< NULL = all weigh 1
    size_t bound;     ///< columns and bins are below
} rsv_transport_list;

/// Columns of weight 1 and tinted ones, then bins likewise.
enum { RSV_TRANSPORT_LISTS = 4 };

/// The lists of rows that are kept as they were traced. @return false = these are not
bool rsv_transport_list_rows(
    rsv_transport *transport, rsv_transport_list list[RSV_TRANSPORT_LISTS]);

/// Rows to be filled through their lists, `scale` and `gathered`, all of which are NULL; then rsv_transport_filled.
rsv_status rsv_transport_create_empty(
    rsv_context *context, size_t row_count, rsv_transport **transport);
void rsv_transport_filled(rsv_transport *transport);

/// Where the rows of a list begin when those of all processes are there.
/// @param whole out: [row_count + 1], to be freed
rsv_status rsv_transport_whole_begin(
    const rsv_transport *transport, const size_t *begin, size_t **whole);

#endif
