/// Rows as they were traced, in compressed form.
#ifndef RSV_STORED_ROWS_INTERNAL_H
#define RSV_STORED_ROWS_INTERNAL_H

#include "transport.h"

typedef struct rsv_stored_rows {
    rsv_transport transport; ///< first, so that either is the other
    size_t *row_begin;       ///< [row_count + 1] into column
    uint32_t *column;        ///< ends of weight 1
    size_t *tinted_begin;    ///< [row_count + 1] into tinted_column and tinted_weight
    uint32_t *tinted_column;
    rsv_rgb *tinted_weight;
} rsv_stored_rows;

extern const rsv_transport_table rsv_stored_rows_table;

/// @param transport whose table is that one
RSV_INLINE rsv_stored_rows *rsv_stored_rows_of(const rsv_transport *transport)
{
    RSV_ASSERT(transport->table == &rsv_stored_rows_table);
    return (rsv_stored_rows *)(uintptr_t)transport;
}

/// As rsv_transport_table.complete.
rsv_status rsv_stored_rows_complete(rsv_transport *transport);

#endif
