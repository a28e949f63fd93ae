/// G by columns: whom an element shines on. For the transposed operator and for shooting.
#ifndef RSV_TRANSPORT_COLUMNS_H
#define RSV_TRANSPORT_COLUMNS_H

#include "transport.h"

/// A copy of G's entries, column by column, rows in their order: as much memory as G itself.
typedef struct rsv_transport_columns {
    const rsv_transport *transport; ///< borrowed: its scales count
    size_t *column_begin;           ///< [row_count + 1] into row
    uint32_t *row;                  ///< entries of weight 1
    size_t *tinted_begin;           ///< [row_count + 1] into tinted_row and tinted_weight
    uint32_t *tinted_row;
    rsv_rgb *tinted_weight;
} rsv_transport_columns;

rsv_status rsv_transport_columns_create(
    const rsv_transport *transport, rsv_transport_columns **columns);
void rsv_transport_columns_destroy(rsv_transport_columns *columns);

/// exitance = G* irradiance, both [row_count x fields]: how much each element's exitance matters where irradiance has
/// the weights `irradiance`. A field does not depend on how many there are.
/// @param scratch [row_count x fields]
void rsv_transport_apply_transpose(const rsv_transport_columns *columns, size_t fields,
    const rsv_rgb *irradiance, rsv_rgb *scratch, rsv_rgb *exitance);

/// irradiance += G times `exitance` at one node: its light on all elements.
/// @param stride of `irradiance`, in RGB values @return number of entries read
size_t rsv_transport_shoot(const rsv_transport_columns *columns, size_t node, rsv_rgb exitance,
    size_t stride, rsv_rgb *irradiance);

#endif
