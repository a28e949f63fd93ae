/// Rows of G for several fields at once: a row comes from memory once for all of them.
#ifndef RSV_TRANSPORT_ROWS_H
#define RSV_TRANSPORT_ROWS_H

#include "transport.h"

/// irradiance = G exitance in rows [begin, end). Fields are [row_count x fields], node by node.
void rsv_transport_gather(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance);

/// Reads what an application reads and does nothing else: per row the sum of a field at its ends. What an application
/// could cost at best.
void rsv_transport_gather_only(const rsv_transport *transport, const rsv_rgb *field, rsv_rgb *sum);

/// residual = source + G exitance - irradiance, with sums in double.
void rsv_transport_residual(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual);

/// What tables of rows may use: row by row, one process's.
void rsv_gather_by_rows(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance);
void rsv_residual_by_rows(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual);

#endif
