#include "directional.h"

#include "look_up_kernels.h"

// ---- making them ----------------------------------------------------------------------------------

static void number_receivers(rsv_directional *d)
{
    uint64_t count = 0, tinted = 0;
    for (size_t n = 0; n < d->elements->node_count; n++) {
        rsv_receiver_word *word = &d->word[n / 64];
        if (n % 64 == 0) word->below = count, word->tinted_below = tinted;
        if (d->transport->scale[n] == 0) continue;
        word->bits |= UINT64_C(1) << n % 64;
        count++;
        tinted += rsv_transport_row_at(d->transport, n).tinted_count;
    }
    d->tinted_count = tinted;
}

/// Rays of rows are distributed by projected solid angle.
static void find_shares(rsv_directional *d)
{
    double all = 0;
    for (size_t k = 0; k < RSV_DIRECTION_SETS * RSV_DIRECTION_BINS; k++) {
        d->share[k % RSV_DIRECTION_BINS] += d->rows->rays[k];
        all += d->rows->rays[k];
    }
    for (size_t bin = 0; bin < RSV_DIRECTION_BINS && all > 0; bin++)
        d->share[bin] = (float)(d->share[bin] / all);
}

static rsv_status check(const rsv_transport *t)
{
    if (!t->directions)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "light by direction: the operator does not know where its entries come from: operator "
            "files and rows brought together from several processes do not keep it; solve anew in "
            "one process");
    if (t->division)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "light by direction: rows are divided among processes; use one process");
    return RSV_OK;
}

rsv_status rsv_directional_create(
    const rsv_elements *elements, const rsv_transport *transport, rsv_directional **directional)
{
    rsv_directional *d = NULL;
    rsv_context *context = elements->context;
    rsv_status status;
    RSV_TRY(check(transport));
    d = rsv_alloc(context, 1, sizeof *d);
    RSV_TRY(d ? RSV_OK : RSV_ERROR_MEMORY);
    d->context = context;
    d->elements = elements;
    d->transport = transport;
    d->rows = transport->directions;
    d->kernels = rsv_look_up_kernels_best();
    d->word = rsv_alloc(context, elements->node_count / 64 + 1, sizeof *d->word);
    d->exitance = rsv_alloc(context, elements->node_count + 1, sizeof *d->exitance);
    d->map = rsv_alloc(context, d->rows->count, sizeof *d->map);
    RSV_TRY(d->word && d->map && d->exitance ? RSV_OK : RSV_ERROR_MEMORY);
    number_receivers(d);
    find_shares(d);
    for (size_t k = 0; k < d->rows->count; k++) // as the rows', to eight bits
        for (int axis = 0; axis < 2; axis++)
            d->map[k].tangent[axis] = (uint8_t)(d->rows->row[k].tangent[axis] / 257);
    *directional = d;
    return RSV_OK;
cleanup:
    rsv_directional_destroy(d);
    return status;
}

void rsv_directional_destroy(rsv_directional *d)
{
    if (!d) return;
    rsv_free(d->context, d->word);
    rsv_free(d->context, d->map);
    rsv_free(d->context, d->exitance);
    rsv_free(d->context, d);
}

size_t rsv_directional_bytes(const rsv_directional *d)
{
    size_t nodes = d->elements->node_count;
    return d->rows->count * (sizeof *d->map + sizeof *d->rows->row) +
           d->tinted_count * sizeof *d->rows->tinted_bin + (nodes / 64 + 1) * sizeof *d->word;
}

size_t rsv_directional_count(const rsv_directional *d) { return d->rows->count; }

// ---- light ----------------------------------------------------------------------------------------

/// Sum at some ends, of which there are few. Two sums at once, as additions that wait for each other would take longer than the
/// loads; and nothing to decide but how many fours there are.
static rsv_cell4 sum_of(
    const uint32_t *column, uint32_t count, const rsv_cell4 *exitance, uint32_t black)
{
    rsv_cell4 even = { 0, 0, 0, 0 }, odd = even;
    for (; count >= 4; count -= 4, column += 4) {
        even += exitance[column[0]] + exitance[column[1]];
        odd += exitance[column[2]] + exitance[column[3]];
    }
    if (count == 0) return even + odd;
    uint32_t second = column[count > 1], third = column[count > 2 ? 2 : 0];
    even += exitance[column[0]];
    odd += exitance[count > 1 ? second : black] + exitance[count > 2 ? third : black];
    return even + odd;
}

static rsv_cell4 tint(rsv_cell4 cell, rsv_rgb weight)
{
    return rsv_cell_of(rgb_mul(weight, rsv_rgb_of_cell(cell[0], cell[1], cell[2])));
}

/// Exitance at the ends of a row's rays, added up by bin. @param tinted_bin of its tinted entries
static void add_ends(const rsv_directional *d, const rsv_transport_row *row, size_t receiver,
    const uint8_t *tinted_bin, rsv_cell4 *sum)
{
    const uint8_t *ends = d->rows->row[receiver].ends;
    const uint32_t *column = row->column;
    uint32_t black = (uint32_t)d->elements->node_count;
    for (size_t bin = 0; bin < RSV_DIRECTION_BINS; bin++) {
        sum[bin] = sum_of(column, ends[bin], d->exitance, black);
        column += ends[bin];
    }
    for (size_t k = 0; k < row->tinted_count; k++)
        if (tinted_bin[k] != RSV_NO_BIN)
            sum[tinted_bin[k]] += tint(d->exitance[row->tinted_column[k]], row->tinted_weight[k]);
}

/// What makes means of the sums, times the shares of the bins.
static void find_scales(const rsv_directional *d, size_t receiver, float *scale)
{
    const rsv_row_direction *row = &d->rows->row[receiver];
    const uint16_t *all = d->rows->rays + (size_t)row->set * RSV_DIRECTION_BINS;
    uint8_t shut[RSV_DIRECTION_BINS];
    for (size_t k = 0; k < RSV_DIRECTION_BINS / 2; k++)
        shut[2 * k] = row->shut[k] & 15, shut[2 * k + 1] = row->shut[k] >> 4;
    for (size_t bin = 0; bin < RSV_DIRECTION_BINS; bin++) {
        float rays = (float)((int32_t)all[bin] - (int32_t)(shut[bin] * d->rows->shut_unit));
        scale[bin] = rays > 0 ? d->share[bin] / (RSV_PI * f_max(rays, 1)) : 0;
    }
}

static void refresh_map(
    rsv_directional *d, const rsv_transport_row *row, size_t receiver, const uint8_t *tinted_bin)
{
    rsv_map_cells cells;
    float scale[RSV_DIRECTION_BINS];
    for (size_t k = RSV_MAP_LUMA + 1; k < RSV_MAP_LUMA + 4; k++)
        cells.cell[k] = (rsv_cell4){ 0, 0, 0, 0 };
    add_ends(d, row, receiver, tinted_bin, cells.cell);
    find_scales(d, receiver, scale);
    for (size_t bin = 0; bin < RSV_DIRECTION_BINS; bin++) {
        float weight = scale[bin] > 0 ? d->share[bin] : 0;
        cells.cell[bin] = cells.cell[bin] * scale[bin] + (rsv_cell4){ 0, 0, 0, weight };
    }
    rsv_directional_map_pack(&cells, &d->map[receiver]);
}

rsv_status rsv_directional_refresh(rsv_directional *d, const rsv_rgb *exitance)
{
    size_t nodes = d->elements->node_count, words = nodes / 64 + 1;
#pragma omp parallel for schedule(static) num_threads(rsv_threads(d->context))
    for (size_t n = 0; n < nodes; n++)
        d->exitance[n] = rsv_cell_of(exitance[n]);
#pragma omp parallel for schedule(dynamic, 4) num_threads(rsv_threads(d->context))
    for (size_t w = 0; w < words; w++) {
        size_t receiver = d->word[w].below;
        const uint8_t *tinted_bin = d->rows->tinted_bin + d->word[w].tinted_below;
        for (uint64_t left = d->word[w].bits; left; left &= left - 1) {
            size_t node = 64 * w + (size_t)__builtin_ctzll(left);
            rsv_transport_row row = rsv_transport_row_at(d->transport, node);
            refresh_map(d, &row, receiver++, tinted_bin);
            tinted_bin += row.tinted_count;
        }
    }
    return RSV_OK;
}
