/// Rows of G for several fields at once: a row comes from memory once for all of them.
#ifndef RSV_TRANSPORT_ROWS_H
#define RSV_TRANSPORT_ROWS_H

#include "transport.h"

/// irradiance = G exitance in rows [begin, end). Fields are [row_count x fields], node by node.
void rsv_transport_gather(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance);

/// Only reads what an application of G reads: per row, the sum of a field at its ends. The minimum cost of an
/// application.
void rsv_transport_gather_only(const rsv_transport *transport, const rsv_rgb *field, rsv_rgb *sum);

/// residual = source + G exitance - irradiance, with sums in double.
void rsv_transport_residual(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual);

/// Sum of a field at the ends of a row. Four sums at once: additions that wait for each other would take longer than
/// the loads.
RSV_INLINE rsv_rgb rsv_sum_ends(
    const uint32_t *column, size_t count, const rsv_rgb *field, size_t stride)
{
    rsv_rgb sum[4] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    size_t k = 0;
    for (; k + 4 <= count; k += 4)
        for (size_t lane = 0; lane < 4; lane++)
            sum[lane] = rgb_add(sum[lane], field[column[k + lane] * stride]);
    for (; k < count; k++)
        sum[0] = rgb_add(sum[0], field[column[k] * stride]);
    return rgb_add(rgb_add(sum[0], sum[1]), rgb_add(sum[2], sum[3]));
}

/// A product that workers share, in spans of rows from `begin` on.
typedef struct rsv_row_product {
    const rsv_transport *transport;
    size_t fields;
    const rsv_rgb *exitance;
    size_t begin;
    rsv_rgb *irradiance;
} rsv_row_product;

/// Functions for tables of rows: row by row, for the rows of one process.
void rsv_gather_by_rows(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance);
void rsv_residual_by_rows(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual);

#endif
