#include "../core/parallel.h"
#include "operator_constants.h"
#include "transport_columns.h"

#include <string.h>

/// Counts entries by column into begin[column + 1] and adds them up.
static void count_columns(rsv_transport_columns *c)
{
    const rsv_transport *t = c->transport;
    for (size_t n = 0; n < t->row_count; n++) {
        rsv_transport_row row = rsv_transport_row_at(t, n);
        for (size_t k = 0; k < row.count; k++)
            c->column_begin[row.column[k] + 1]++;
        for (size_t k = 0; k < row.tinted_count; k++)
            c->tinted_begin[row.tinted_column[k] + 1]++;
    }
    for (size_t n = 0; n < t->row_count; n++) {
        c->column_begin[n + 1] += c->column_begin[n];
        c->tinted_begin[n + 1] += c->tinted_begin[n];
    }
}

/// Goes through the rows in their order, so that each column lists its rows in order.
static void fill(rsv_transport_columns *c, size_t *next, size_t *next_tinted)
{
    const rsv_transport *t = c->transport;
    memcpy(next, c->column_begin, t->row_count * sizeof *next);
    memcpy(next_tinted, c->tinted_begin, t->row_count * sizeof *next_tinted);
    for (size_t n = 0; n < t->row_count; n++) {
        rsv_transport_row row = rsv_transport_row_at(t, n);
        for (size_t k = 0; k < row.count; k++)
            c->row[next[row.column[k]]++] = (uint32_t)n;
        for (size_t k = 0; k < row.tinted_count; k++) {
            size_t at = next_tinted[row.tinted_column[k]]++;
            c->tinted_row[at] = (uint32_t)n;
            c->tinted_weight[at] = row.tinted_weight[k];
        }
    }
}

rsv_status rsv_transport_columns_create(const rsv_transport *t, rsv_transport_columns **columns)
{
    rsv_context *context = t->context;
    rsv_status status = RSV_OK;
    size_t *next = rsv_alloc(context, t->row_count, sizeof *next);
    size_t *next_tinted = rsv_alloc(context, t->row_count, sizeof *next_tinted);
    rsv_transport_columns *c = rsv_alloc(context, 1, sizeof *c);
    *columns = NULL;
    if (!c || !next || !next_tinted) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    c->transport = t;
    c->column_begin = rsv_alloc(context, t->row_count + 1, sizeof *c->column_begin);
    c->tinted_begin = rsv_alloc(context, t->row_count + 1, sizeof *c->tinted_begin);
    RSV_TRY(c->column_begin && c->tinted_begin ? RSV_OK : RSV_ERROR_MEMORY);
    count_columns(c);
    size_t tinted = c->tinted_begin[t->row_count];
    c->row = rsv_alloc(context, c->column_begin[t->row_count], sizeof *c->row);
    c->tinted_row = rsv_alloc(context, tinted, sizeof *c->tinted_row);
    c->tinted_weight = rsv_alloc(context, tinted, sizeof *c->tinted_weight);
    RSV_TRY(c->row && c->tinted_row && c->tinted_weight ? RSV_OK : RSV_ERROR_MEMORY);
    fill(c, next, next_tinted);
    *columns = c;
cleanup:
    rsv_free(context, next);
    rsv_free(context, next_tinted);
    if (status != RSV_OK && c) {
        c->transport = t; // has the context
        rsv_transport_columns_destroy(c);
    }
    return status;
}

void rsv_transport_columns_destroy(rsv_transport_columns *c)
{
    if (!c) return;
    rsv_context *context = c->transport->context;
    rsv_free(context, c->column_begin);
    rsv_free(context, c->row);
    rsv_free(context, c->tinted_begin);
    rsv_free(context, c->tinted_row);
    rsv_free(context, c->tinted_weight);
    rsv_free(context, c);
}

/// Fields that are summed side by side: their sums fit into registers.
#define WIDE 8

static void add_wide(float sum[3 * WIDE], const rsv_rgb *from)
{
    for (int i = 0; i < 3 * WIDE; i++)
        sum[i] += (&from->r)[i];
}

/// A column's sums of `WIDE` fields. @param scaled the first of these fields at row 0
static void sum_wide(const rsv_transport_columns *c, size_t node, size_t fields,
    const rsv_rgb *scaled, rsv_rgb *sums)
{
    float sum[3 * WIDE] = { 0 };
    for (size_t k = c->column_begin[node]; k < c->column_begin[node + 1]; k++)
        add_wide(sum, scaled + c->row[k] * fields);
    for (size_t k = c->tinted_begin[node]; k < c->tinted_begin[node + 1]; k++) {
        rsv_rgb tinted[WIDE];
        for (int f = 0; f < WIDE; f++)
            tinted[f] = rgb_mul(c->tinted_weight[k], scaled[c->tinted_row[k] * fields + (size_t)f]);
        add_wide(sum, tinted);
    }
    memcpy(sums, sum, sizeof sum);
}

static rsv_rgb sum_one(
    const rsv_transport_columns *c, size_t node, size_t fields, const rsv_rgb *scaled)
{
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = c->column_begin[node]; k < c->column_begin[node + 1]; k++)
        sum = rgb_add(sum, scaled[c->row[k] * fields]);
    for (size_t k = c->tinted_begin[node]; k < c->tinted_begin[node + 1]; k++)
        sum = rgb_add(sum, rgb_mul(c->tinted_weight[k], scaled[c->tinted_row[k] * fields]));
    return sum;
}

typedef struct transpose_job {
    const rsv_transport_columns *columns;
    size_t fields;
    const rsv_rgb *irradiance;
    rsv_rgb *scaled, *exitance; ///< scaled: irradiance, times the weight of each row
} transpose_job;

static void scale_rows(void *data, rsv_span span)
{
    const transpose_job job = *(const transpose_job *)data;
    const float *scale = job.columns->transport->scale;
    for (size_t row = span.begin; row < span.end; row++)
        for (size_t k = row * job.fields; k < (row + 1) * job.fields; k++)
            job.scaled[k] = rgb_scale(job.irradiance[k], scale[row]);
}

static void sum_columns(void *data, rsv_span span)
{
    const transpose_job job = *(const transpose_job *)data;
    const rsv_transport_columns *c = job.columns;
    size_t fields = job.fields;
    for (size_t node = span.begin; node < span.end; node++) {
        size_t f = 0;
        for (; f + WIDE <= fields; f += WIDE)
            sum_wide(c, node, fields, job.scaled + f, job.exitance + node * fields + f);
        for (; f < fields; f++)
            job.exitance[node * fields + f] = sum_one(c, node, fields, job.scaled + f);
    }
}

void rsv_transport_apply_transpose(const rsv_transport_columns *columns, size_t fields,
    const rsv_rgb *irradiance, rsv_rgb *scratch, rsv_rgb *exitance)
{
    const rsv_transport *t = columns->transport;
    size_t rows = t->row_count;
    bool parallel = rsv_transport_entries(t) * fields > PARALLEL_ENTRIES;
    transpose_job job = { columns, fields, irradiance, scratch, exitance };
    rsv_parallel_for(t->context, rows, parallel ? 0 : rows, scale_rows, &job);
    rsv_parallel_for(t->context, rows, parallel ? 64 : rows, sum_columns, &job);
}

size_t rsv_transport_shoot(const rsv_transport_columns *columns, size_t node, rsv_rgb exitance,
    size_t stride, rsv_rgb *irradiance)
{
    const rsv_transport_columns *c = columns;
    const float *scale = c->transport->scale;
    for (size_t k = c->column_begin[node]; k < c->column_begin[node + 1]; k++) {
        rsv_rgb *e = &irradiance[c->row[k] * stride];
        *e = rgb_mad(*e, scale[c->row[k]], exitance);
    }
    for (size_t k = c->tinted_begin[node]; k < c->tinted_begin[node + 1]; k++) {
        rsv_rgb *e = &irradiance[c->tinted_row[k] * stride];
        *e = rgb_mad(*e, scale[c->tinted_row[k]], rgb_mul(c->tinted_weight[k], exitance));
    }
    return c->column_begin[node + 1] - c->column_begin[node] + c->tinted_begin[node + 1] -
           c->tinted_begin[node];
}
