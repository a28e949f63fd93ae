#include "transport_rows.h"

/// Entries below which waking the threads takes longer than the work.
#define PARALLEL_ENTRIES 65536

/// Sum of a field at the ends of a row. Four sums at once: additions that wait for each other would take longer than
/// the loads.
static rsv_rgb sum_ends(const uint32_t *column, size_t count, const rsv_rgb *field, size_t stride)
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

void rsv_transport_gather(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
    size_t entries = t->row_begin[end] - t->row_begin[begin];
#pragma omp parallel for schedule(dynamic, 64)                                                     \
    num_threads(rsv_threads(t->context)) if (entries * fields > PARALLEL_ENTRIES)
    for (size_t row = begin; row < end; row++) {
        for (size_t f = 0; f < fields; f++) {
            size_t first = t->row_begin[row];
            rsv_rgb sum =
                sum_ends(t->column + first, t->row_begin[row + 1] - first, exitance + f, fields);
            for (size_t k = t->tinted_begin[row]; k < t->tinted_begin[row + 1]; k++)
                sum = rgb_add(
                    sum, rgb_mul(t->tinted_weight[k], exitance[t->tinted_column[k] * fields + f]));
            irradiance[row * fields + f] = rgb_scale(sum, t->scale[row]);
        }
    }
    rsv_division_share(t->division, irradiance, fields * sizeof *irradiance);
}

void rsv_transport_gather_only(const rsv_transport *t, const rsv_rgb *field, rsv_rgb *sum)
{
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(t->context))
    for (size_t row = 0; row < t->row_count; row++) {
        size_t first = t->row_begin[row];
        sum[row] = sum_ends(t->column + first, t->row_begin[row + 1] - first, field, 1);
    }
}

static void add_row(const rsv_transport *t, size_t row, size_t fields, size_t field,
    const rsv_rgb *exitance, double sum[3])
{
    for (size_t k = t->row_begin[row]; k < t->row_begin[row + 1]; k++) {
        rsv_rgb b = exitance[t->column[k] * fields + field];
        sum[0] += (double)b.r, sum[1] += (double)b.g, sum[2] += (double)b.b;
    }
    for (size_t k = t->tinted_begin[row]; k < t->tinted_begin[row + 1]; k++) {
        rsv_rgb b = exitance[t->tinted_column[k] * fields + field], w = t->tinted_weight[k];
        sum[0] += (double)b.r * w.r, sum[1] += (double)b.g * w.g, sum[2] += (double)b.b * w.b;
    }
}

void rsv_transport_residual(const rsv_transport *t, size_t fields, const rsv_rgb *exitance,
    const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual)
{
#pragma omp parallel for schedule(dynamic, 64)                                                     \
    num_threads(rsv_threads(t->context)) if (rsv_transport_entries(t) * fields > PARALLEL_ENTRIES)
    for (size_t row = 0; row < t->row_count; row++) {
        double scale = t->scale[row];
        for (size_t f = 0; f < fields; f++) {
            size_t k = row * fields + f;
            double sum[3] = { 0, 0, 0 };
            add_row(t, row, fields, f, exitance, sum);
            residual[k] = rgb((float)(source[k].r + sum[0] * scale - irradiance[k].r),
                (float)(source[k].g + sum[1] * scale - irradiance[k].g),
                (float)(source[k].b + sum[2] * scale - irradiance[k].b));
        }
    }
    rsv_division_share(t->division, residual, fields * sizeof *residual);
}
