/// Rows as lists, for files and devices, which store them without knowing their meaning.
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

/// Columns of weight 1, tinted columns, and the same two of bins.
enum { RSV_TRANSPORT_LISTS = 4 };

/// The lists of rows that are kept as they were traced. @return false = these are not
bool rsv_transport_list_rows(
    rsv_transport *transport, rsv_transport_list list[RSV_TRANSPORT_LISTS]);

/// Rows to fill through their lists, `scale` and `gathered`, which are NULL. Then call rsv_transport_filled.
rsv_status rsv_transport_create_empty(
    rsv_context *context, size_t row_count, rsv_transport **transport);
void rsv_transport_filled(rsv_transport *transport);

/// Starts of the rows of a list when those of all processes are included.
/// @param whole out: [row_count + 1], freed by the caller
rsv_status rsv_transport_whole_begin(
    const rsv_transport *transport, const size_t *begin, size_t **whole);

#endif
