/// Rows of all processes, brought to all.
#include "../core/team.h"
#include "stored_rows_internal.h"
#include "transport_lists.h"

#include <string.h>

rsv_status rsv_transport_whole_begin(const rsv_transport *t, const size_t *begin, size_t **whole)
{
    size_t *sum = *whole = rsv_alloc(t->context, t->row_count + 1, sizeof *sum);
    if (!sum) return RSV_ERROR_MEMORY;
    for (size_t row = 0; row < t->row_count; row++)
        sum[row + 1] = begin[row + 1] - begin[row];
    rsv_division_share(t->division, sum + 1, sizeof *sum);
    for (size_t row = 0; row < t->row_count; row++)
        sum[row + 1] += sum[row];
    return rsv_team_meet(t->context, RSV_OK);
}

/// Entries of a part's rows, one row after the other along the curve. @param begin of the rows in `items`
static void pack(const rsv_division *d, uint32_t part, const size_t *begin, const char *items,
    size_t item_bytes, char *packed)
{
    for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++) {
        size_t first = begin[d->order[k]], bytes = (begin[d->order[k] + 1] - first) * item_bytes;
        if (bytes) memcpy(packed, items + first * item_bytes, bytes);
        packed += bytes;
    }
}

static void unpack(
    const rsv_division *d, const size_t *begin, const char *packed, size_t item_bytes, char *items)
{
    for (size_t k = 0; k < d->node_count; k++) {
        size_t first = begin[d->order[k]], bytes = (begin[d->order[k] + 1] - first) * item_bytes;
        if (bytes) memcpy(items + first * item_bytes, packed, bytes);
        packed += bytes;
    }
}

/// @param own, whole where rows begin here, and when all are here
static rsv_status complete_items(
    const rsv_transport *t, const size_t *own, const size_t *whole, size_t item_bytes, void **items)
{
    rsv_status status = RSV_OK;
    const rsv_division *d = t->division;
    size_t total = whole[t->row_count];
    char *packed = rsv_reserve(t->context, total, item_bytes);
    char *all = rsv_reserve(t->context, total, item_bytes);
    size_t *begin = rsv_alloc(t->context, (size_t)d->part_count + 1, sizeof *begin);
    RSV_TRY(rsv_team_meet(t->context, packed && all && begin ? RSV_OK : RSV_ERROR_MEMORY));
    for (uint32_t part = 0; part < d->part_count; part++) {
        begin[part + 1] = begin[part];
        for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
            begin[part + 1] += whole[d->order[k] + 1] - whole[d->order[k]];
    }
    pack(d, d->part, own, *items, item_bytes, packed + begin[d->part] * item_bytes);
    rsv_team_share(t->context, packed, item_bytes, begin);
    unpack(d, whole, packed, item_bytes, all);
    rsv_free(t->context, *items);
    *items = all;
    all = NULL;
cleanup:
    rsv_free(t->context, packed);
    rsv_free(t->context, all);
    rsv_free(t->context, begin);
    return status;
}

/// Rows with one or two arrays of entries. @param second NULL = there is one
static rsv_status complete_list(const rsv_transport *t, size_t *begin, size_t first_bytes,
    void **first, size_t second_bytes, void **second)
{
    size_t *whole;
    rsv_status status = rsv_transport_whole_begin(t, begin, &whole);
    if (status == RSV_OK) status = complete_items(t, begin, whole, first_bytes, first);
    if (status == RSV_OK && second) status = complete_items(t, begin, whole, second_bytes, second);
    if (status == RSV_OK) memcpy(begin, whole, (t->row_count + 1) * sizeof *begin);
    rsv_free(t->context, whole);
    return status;
}

rsv_status rsv_stored_rows_complete(rsv_transport *transport)
{
    rsv_status status;
    rsv_stored_rows *t = rsv_stored_rows_of(transport);
    rsv_escapes *e = &transport->escapes;
    rsv_escape_list *l = &e->list;
    RSV_TRY(
        complete_list(transport, t->row_begin, sizeof *t->column, (void **)&t->column, 0, NULL));
    RSV_TRY(complete_list(transport, t->tinted_begin, sizeof *t->tinted_column,
        (void **)&t->tinted_column, sizeof *t->tinted_weight, (void **)&t->tinted_weight));
    RSV_TRY(complete_list(transport, e->begin, sizeof *l->bin, (void **)&l->bin, 0, NULL));
    RSV_TRY(complete_list(transport, e->tinted_begin, sizeof *l->tinted_bin,
        (void **)&l->tinted_bin, sizeof *l->tinted_weight, (void **)&l->tinted_weight));
    rsv_transport_filled(transport);
    l->bin_capacity = l->count;
    l->tinted_bin_capacity = l->tinted_weight_capacity = l->tinted_count;
    rsv_division_destroy(transport->division);
    transport->division = NULL;
cleanup:
    return status;
}
