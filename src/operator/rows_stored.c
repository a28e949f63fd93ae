#include "../core/parallel.h"
#include "operator_constants.h"
#include "stored_rows_internal.h"
#include "transport_lists.h"
#include "transport_rows.h"

static void gather_rows(void *job, rsv_span span)
{
    const rsv_row_product p = *(const rsv_row_product *)job;
    const rsv_stored_rows *t = rsv_stored_rows_of(p.transport);
    for (size_t row = p.begin + span.begin; row < p.begin + span.end; row++) {
        for (size_t f = 0; f < p.fields; f++) {
            size_t first = t->row_begin[row];
            rsv_rgb sum = rsv_sum_ends(
                t->column + first, t->row_begin[row + 1] - first, p.exitance + f, p.fields);
            for (size_t k = t->tinted_begin[row]; k < t->tinted_begin[row + 1]; k++)
                sum = rgb_add(sum,
                    rgb_mul(t->tinted_weight[k], p.exitance[t->tinted_column[k] * p.fields + f]));
            p.irradiance[row * p.fields + f] = rgb_scale(sum, p.transport->scale[row]);
        }
    }
}

static void gather(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
    size_t begin, size_t end, rsv_rgb *irradiance)
{
    const rsv_stored_rows *t = rsv_stored_rows_of(transport);
    size_t entries = t->row_begin[end] - t->row_begin[begin];
    size_t grain = entries * fields > PARALLEL_ENTRIES ? 64 : end - begin;
    rsv_row_product p = { transport, fields, exitance, begin, irradiance };
    rsv_parallel_for(transport->context, end - begin, grain, gather_rows, &p);
}

static void sum_row_ends(void *job, rsv_span span)
{
    const rsv_row_product *p = job;
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_transport_row row = rsv_transport_row_at(p->transport, k);
        p->irradiance[k] = rsv_sum_ends(row.column, row.count, p->exitance, 1);
    }
}

void rsv_transport_gather_only(const rsv_transport *t, const rsv_rgb *field, rsv_rgb *sum)
{
    rsv_row_product p = { t, 1, field, 0, sum };
    rsv_parallel_for(t->context, t->row_count, 64, sum_row_ends, &p);
}

// ---- the table ------------------------------------------------------------------------------------

static void destroy(rsv_transport *transport)
{
    rsv_stored_rows *t = rsv_stored_rows_of(transport);
    rsv_free(transport->context, t->row_begin);
    rsv_free(transport->context, t->column);
    rsv_free(transport->context, t->tinted_begin);
    rsv_free(transport->context, t->tinted_column);
    rsv_free(transport->context, t->tinted_weight);
}

static rsv_transport_row get_row(const rsv_transport *transport, size_t row)
{
    const rsv_stored_rows *t = rsv_stored_rows_of(transport);
    size_t first = t->row_begin[row], tinted = t->tinted_begin[row];
    return (rsv_transport_row){ t->column + first, t->tinted_column + tinted,
        t->tinted_weight + tinted, t->row_begin[row + 1] - first,
        t->tinted_begin[row + 1] - tinted };
}

static size_t entries(const rsv_transport *transport)
{
    const rsv_stored_rows *t = rsv_stored_rows_of(transport);
    return t->row_begin[transport->row_count] + t->tinted_begin[transport->row_count];
}

static size_t bytes(const rsv_transport *transport)
{
    const rsv_stored_rows *t = rsv_stored_rows_of(transport);
    size_t tinted = t->tinted_begin[transport->row_count];
    return transport->row_count * (sizeof *t->row_begin + sizeof *t->tinted_begin) +
           t->row_begin[transport->row_count] * sizeof *t->column +
           tinted * (sizeof *t->tinted_column + sizeof *t->tinted_weight);
}

const rsv_transport_table rsv_stored_rows_table = { destroy, get_row, gather, rsv_residual_by_rows,
    rsv_stored_rows_complete, entries, bytes };

// ---- lists ----------------------------------------------------------------------------------------

bool rsv_transport_list_rows(rsv_transport *transport, rsv_transport_list list[RSV_TRANSPORT_LISTS])
{
    if (transport->table != &rsv_stored_rows_table) return false;
    rsv_stored_rows *t = rsv_stored_rows_of(transport);
    rsv_escapes *e = &transport->escapes;
    rsv_escape_list *l = &e->list;
    size_t rows = transport->row_count, bins = RSV_ESCAPE_BINS;
    list[0] = (rsv_transport_list){ "transport.", &t->row_begin, &t->column, NULL, NULL, rows };
    list[1] = (rsv_transport_list){ "transport.tinted.", &t->tinted_begin, &t->tinted_column, NULL,
        &t->tinted_weight, rows };
    list[2] = (rsv_transport_list){ "escape.", &e->begin, NULL, &l->bin, NULL, bins };
    list[3] = (rsv_transport_list){ "escape.tinted.", &e->tinted_begin, NULL, &l->tinted_bin,
        &l->tinted_weight, bins };
    return true;
}

rsv_status rsv_transport_create_empty(
    rsv_context *context, size_t row_count, rsv_transport **transport)
{
    rsv_stored_rows *t = rsv_alloc(context, 1, sizeof *t);
    if (!t) return RSV_ERROR_MEMORY;
    t->transport.table = &rsv_stored_rows_table;
    t->transport.context = context;
    t->transport.row_count = row_count;
    *transport = &t->transport;
    return RSV_OK;
}

void rsv_transport_filled(rsv_transport *t)
{
    t->escapes.list.count = t->escapes.begin[t->row_count];
    t->escapes.list.tinted_count = t->escapes.tinted_begin[t->row_count];
}
