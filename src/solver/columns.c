#include "columns.h"

#include "../core/parallel.h"

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

/// Data of a loop over rows. There is one factor per column.
typedef struct columns_job {
    const rsv_field_shape *shape;
    const double *factor;
    const float *x;
    float *y;
} columns_job;

/// A loop over all rows; on the calling thread only if there are few.
static void for_rows(void (*body)(void *, rsv_span), columns_job *job)
{
    const rsv_field_shape *s = job->shape;
    rsv_parallel_for(s->context, s->count, s->count > PARALLEL_ROWS ? 0 : s->count, body, job);
}

typedef struct dot_job {
    const rsv_field_shape *shape;
    const float *a, *b;
} dot_job;

static void sum_blocks(void *job, rsv_span span)
{
    const rsv_field_shape *s = ((const dot_job *)job)->shape;
    const float *a = ((const dot_job *)job)->a, *b = ((const dot_job *)job)->b;
    size_t columns = s->columns;
    for (size_t block = span.begin; block < span.end; block++) {
        double *sum = s->partial + block * columns;
        memset(sum, 0, columns * sizeof *sum);
        for (size_t n = block * ROWS_PER_SUM; n < block_end(s, block); n++)
            for (size_t c = 0; c < columns; c++)
                sum[c] += (double)a[n * columns + c] * b[n * columns + c];
    }
}

void rsv_columns_dot(const rsv_field_shape *s, const float *a, const float *b, double *product)
{
    size_t columns = s->columns, blocks = block_count(s->count);
    size_t grain = s->count > PARALLEL_ROWS ? 0 : blocks;
    rsv_parallel_for(s->context, blocks, grain, sum_blocks, &(dot_job){ s, a, b });
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

static void add_rows(void *data, rsv_span span)
{
    const columns_job job = *(const columns_job *)data;
    size_t columns = job.shape->columns;
    for (size_t n = span.begin; n < span.end; n++)
        for (size_t c = 0; c < columns; c++)
            job.y[n * columns + c] += (float)job.factor[c] * job.x[n * columns + c];
}

void rsv_columns_add(const rsv_field_shape *s, const double *factor, const float *x, float *y)
{
    for_rows(add_rows, &(columns_job){ s, factor, x, y });
}

static void scale_add_rows(void *data, rsv_span span)
{
    const columns_job job = *(const columns_job *)data;
    size_t columns = job.shape->columns;
    for (size_t n = span.begin; n < span.end; n++)
        for (size_t c = 0; c < columns; c++)
            job.y[n * columns + c] =
                job.x[n * columns + c] + (float)job.factor[c] * job.y[n * columns + c];
}

void rsv_columns_scale_add(const rsv_field_shape *s, const float *x, const double *factor, float *y)
{
    for_rows(scale_add_rows, &(columns_job){ s, factor, x, y });
}

static void scale_rows(void *data, rsv_span span)
{
    const columns_job job = *(const columns_job *)data;
    size_t columns = job.shape->columns;
    for (size_t n = span.begin; n < span.end; n++)
        for (size_t c = 0; c < columns; c++)
            job.y[n * columns + c] = (float)job.factor[c] * job.x[n * columns + c];
}

void rsv_columns_scale(const rsv_field_shape *s, const double *factor, const float *x, float *y)
{
    for_rows(scale_rows, &(columns_job){ s, factor, x, y });
}

static void sum_rows(void *data, rsv_span span)
{
    const columns_job job = *(const columns_job *)data;
    size_t columns = job.shape->columns;
    for (size_t k = span.begin * columns; k < span.end * columns; k++)
        job.y[k] += job.x[k];
}

void rsv_columns_sum(const rsv_field_shape *s, const float *x, float *y)
{
    for_rows(sum_rows, &(columns_job){ s, NULL, x, y });
}

static void subtract_rows(void *data, rsv_span span)
{
    const columns_job job = *(const columns_job *)data;
    size_t columns = job.shape->columns;
    for (size_t k = span.begin * columns; k < span.end * columns; k++)
        job.y[k] -= job.x[k];
}

void rsv_columns_subtract(const rsv_field_shape *s, const float *x, float *y)
{
    for_rows(subtract_rows, &(columns_job){ s, NULL, x, y });
}
