#include "columns.h"

#include <math.h>
#include <string.h>

#define ROWS_PER_SUM 2048

static size_t block_count(size_t count) { return (count + ROWS_PER_SUM - 1) / ROWS_PER_SUM; }

size_t rsv_partial_length(size_t count, size_t columns) { return block_count(count) * columns; }

/// Loops below run in parallel where waking the threads takes less time than the work.
#define PARALLEL_ROWS 32768

/// The end of a block of rows.
static size_t block_end(const rsv_field_shape *s, size_t block)
{
    size_t end = (block + 1) * ROWS_PER_SUM;
    return end < s->count ? end : s->count;
}

void rsv_columns_dot(const rsv_field_shape *s, const float *a, const float *b, double *product)
{
    size_t columns = s->columns, blocks = block_count(s->count);
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t block = 0; block < blocks; block++) {
        double *sum = s->partial + block * columns;
        memset(sum, 0, columns * sizeof *sum);
        for (size_t n = block * ROWS_PER_SUM; n < block_end(s, block); n++)
            for (size_t c = 0; c < columns; c++)
                sum[c] += (double)a[n * columns + c] * b[n * columns + c];
    }
    memset(product, 0, columns * sizeof *product);
    for (size_t block = 0; block < blocks; block++)
        for (size_t c = 0; c < columns; c++)
            product[c] += s->partial[block * columns + c];
}

void rsv_columns_max(const rsv_field_shape *s, const float *a, double *norm)
{
    memset(norm, 0, s->columns * sizeof *norm);
    for (size_t n = 0; n < s->count; n++) {
        for (size_t c = 0; c < s->columns; c++) {
            double size = fabs((double)a[n * s->columns + c]);
            if (!(size <= norm[c])) norm[c] = isnan(norm[c]) ? norm[c] : size;
        }
    }
}

void rsv_columns_add(const rsv_field_shape *s, const double *factor, const float *x, float *y)
{
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t n = 0; n < s->count; n++)
        for (size_t c = 0; c < s->columns; c++)
            y[n * s->columns + c] += (float)factor[c] * x[n * s->columns + c];
}

void rsv_columns_scale_add(const rsv_field_shape *s, const float *x, const double *factor, float *y)
{
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t n = 0; n < s->count; n++)
        for (size_t c = 0; c < s->columns; c++)
            y[n * s->columns + c] =
                x[n * s->columns + c] + (float)factor[c] * y[n * s->columns + c];
}

void rsv_columns_scale(const rsv_field_shape *s, const double *factor, const float *x, float *y)
{
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t n = 0; n < s->count; n++)
        for (size_t c = 0; c < s->columns; c++)
            y[n * s->columns + c] = (float)factor[c] * x[n * s->columns + c];
}

void rsv_columns_sum(const rsv_field_shape *s, const float *x, float *y)
{
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t k = 0; k < s->count * s->columns; k++)
        y[k] += x[k];
}

void rsv_columns_subtract(const rsv_field_shape *s, const float *x, float *y)
{
#pragma omp parallel for schedule(static)                                                          \
    num_threads(rsv_threads(s->context)) if (s->count > PARALLEL_ROWS)
    for (size_t k = 0; k < s->count * s->columns; k++)
        y[k] -= x[k];
}
