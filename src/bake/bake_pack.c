#include "bake_pack.h"

#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_mask.h"

#include <stdlib.h>
#include <string.h>

static void size_chart(rsv_bake_chart *chart, float density)
{
    for (int axis = 0; axis < 2; axis++) {
        float texels = roundf(chart->size[axis] * chart->detail * density);
        chart->texels[axis] = texels < 2 ? 2 : texels > 65536 ? 65536 : (uint32_t)texels;
    }
}

static int compare_areas(const void *a, const void *b)
{
    const rsv_bake_chart *const *x = a, *const *y = b;
    uint64_t of_x = (uint64_t)(*x)->texels[0] * (*x)->texels[1];
    uint64_t of_y = (uint64_t)(*y)->texels[0] * (*y)->texels[1];
    if (of_x != of_y) return of_x < of_y ? 1 : -1;
    return (*x > *y) - (*x < *y);
}

/// A map while it fills. Rows are bits, 64 columns to a word from its lowest bit on.
typedef struct sheet {
    uint32_t width, rows, padding;
    size_t words; ///< of a row
    uint64_t *taken
        [2]; ///< [rows * words] texels of charts and those around them, for charts that are no rectangles and for those that are
    uint64_t *open; ///< [words] columns where the chart in hand may begin
    uint64_t *near; ///< [words] columns from which on something is taken
    /// [2 * (LARGEST_KIND + 1)] rows where charts of each size were found, those that are no rectangles first
    uint32_t (*kind)[LARGEST_KIND + 1];
    rsv_bake_mask mask; ///< of the chart in hand
} sheet;

static rsv_status create_sheet(
    rsv_context *context, uint32_t width, uint32_t rows, uint32_t padding, sheet *s)
{
    size_t words = ((size_t)width + 63) / 64;
    *s = (sheet){ .width = width,
        .rows = rows,
        .padding = padding,
        .words = words,
        .taken = { rsv_alloc(context, rows * words, sizeof **s->taken),
            rsv_alloc(context, rows * words, sizeof **s->taken) },
        .open = rsv_alloc(context, words, sizeof *s->open),
        .near = rsv_alloc(context, words, sizeof *s->near),
        .kind = rsv_alloc(context, 2 * (LARGEST_KIND + 1), sizeof *s->kind),
        .mask.context = context };
    return s->taken[0] && s->taken[1] && s->open && s->near && s->kind ? RSV_OK : RSV_ERROR_MEMORY;
}

static void destroy_sheet(rsv_context *context, sheet *s)
{
    rsv_free(context, s->taken[0]);
    rsv_free(context, s->taken[1]);
    rsv_free(context, s->open);
    rsv_free(context, s->near);
    rsv_free(context, s->kind);
    rsv_bake_mask_destroy(&s->mask);
}

static void set_bits(uint64_t *row, uint32_t begin, uint32_t end)
{
    for (uint32_t k = begin / 64; k <= (end - 1) / 64; k++) {
        uint64_t from = k == begin / 64 ? ~(uint64_t)0 << begin % 64 : ~(uint64_t)0;
        uint64_t to = k == (end - 1) / 64 ? ~(uint64_t)0 >> (63 - (end - 1) % 64) : ~(uint64_t)0;
        row[k] |= from & to;
    }
}

/// Word `k` of a row from column `by` on.
static uint64_t shifted(const uint64_t *row, size_t words, size_t k, uint32_t by)
{
    size_t from = k + by / 64;
    uint64_t word = from < words ? row[from] >> by % 64 : 0;
    if (by % 64 && from + 1 < words) word |= row[from + 1] << (64 - by % 64);
    return word;
}

/// Closes the columns from which on a run of the chart meets something. @return whether any stays open
static bool keep_open(sheet *s, uint32_t y, rsv_bake_run run)
{
    const uint64_t *row = s->taken[s->mask.is_whole] + (y + run.row) * s->words;
    uint32_t wanted = run.end - run.begin;
    uint64_t any = 0;
    for (size_t k = 0; k < s->words; k++)
        s->near[k] = shifted(row, s->words, k, run.begin);
    for (uint32_t reach = 1; reach < wanted;) {
        uint32_t more = reach < wanted - reach ? reach : wanted - reach;
        for (size_t k = 0; k < s->words; k++)
            s->near[k] |= shifted(s->near, s->words, k, more);
        reach += more;
    }
    for (size_t k = 0; k < s->words; k++)
        any |= s->open[k] &= ~s->near[k];
    return any != 0;
}

/// The first column where the chart in hand fits, its first row being `y`; UINT32_MAX = none.
static uint32_t find_column(sheet *s, uint32_t columns, uint32_t y)
{
    memset(s->open, 0, s->words * sizeof *s->open);
    set_bits(s->open, RIM, RIM + columns);
    for (size_t first = 0; first < RUN_STRIDE; first++)
        for (size_t k = first; k < s->mask.run_count; k += RUN_STRIDE)
            if (!keep_open(s, y, s->mask.run[k])) return UINT32_MAX;
    uint32_t x = RIM;
    while (!(s->open[x / 64] >> x % 64 & 1))
        x++;
    return x;
}

static void take_run(sheet *s, uint64_t *taken, rsv_bake_run run, uint32_t margin)
{
    uint32_t left = run.begin > margin ? run.begin - margin : 0, right = run.end + margin;
    uint32_t low = run.row > margin ? run.row - margin : 0, high = run.row + margin + 1;
    for (uint32_t row = low; row < high && row < s->rows; row++)
        set_bits(taken + row * s->words, left, right < s->width ? right : s->width);
}

/// Takes the texels of the chart in hand, and those around it: filtering in a rectangle reads none of these, so that
/// half the padding parts it from others.
static void take_chart(sheet *s, uint32_t x, uint32_t y)
{
    uint32_t half = (s->padding + 1) / 2;
    for (size_t k = 0; k < s->mask.run_count; k++) {
        rsv_bake_run run = s->mask.run[k];
        run = (rsv_bake_run){ y + run.row, x + run.begin, x + run.end };
        take_run(s, s->taken[false], run, s->mask.is_whole ? half : s->padding);
        take_run(s, s->taken[true], run, half);
    }
}

/// The first row from `*y` on, and there the first column, where the chart in hand fits and ends before row `end`.
static bool find_place(
    sheet *s, const rsv_bake_chart *chart, uint32_t end, uint32_t *x, uint32_t *y)
{
    uint32_t w = chart->texels[0], h = chart->texels[1];
    if (w + 2 * RIM > s->width) return false;
    for (; *y + h + RIM <= s->rows && *y + h < end; (*y)++) {
        *x = find_column(s, s->width - w - 2 * RIM + 1, *y);
        if (*x != UINT32_MAX) return true;
    }
    return false;
}

/// Where charts of the size of that in hand are sought from.
static uint32_t *start_of(sheet *s, const rsv_bake_chart *chart)
{
    uint32_t w = chart->texels[0], h = chart->texels[1];
    uint32_t first = s->mask.is_whole ? LARGEST_KIND + 1 : 0;
    return w <= LARGEST_KIND && h <= LARGEST_KIND ? &s->kind[first + w][h] : NULL;
}

/// Puts a chart where it fits, turned in the way that lets it end in the first row.
/// @param end out: the row above it; UINT32_MAX = it fits nowhere
static rsv_status place(
    sheet *s, const rsv_bake_charts *charts, rsv_bake_chart *chart, uint32_t *end)
{
    rsv_status status;
    rsv_bake_chart best = *chart, turned = *chart;
    *end = UINT32_MAX;
    for (turned.turns = 0; turned.turns < 4; turned.turns++) {
        turned.texels[0] = chart->texels[turned.turns & 1];
        turned.texels[1] = chart->texels[~turned.turns & 1];
        RSV_TRY(rsv_bake_mask_draw(&s->mask, charts, &turned));
        if (s->mask.is_whole && turned.turns == 2) break; // a rectangle is the same again
        uint32_t *start = start_of(s, &turned);
        uint32_t y = start && *start > RIM ? *start : RIM;
        turned.at[1] = y;
        bool found = find_place(s, &turned, *end, &turned.at[0], &turned.at[1]);
        if (start) *start = turned.at[1];
        if (!found) continue;
        best = turned;
        *end = turned.at[1] + turned.texels[1];
    }
    if (*end == UINT32_MAX) return RSV_OK;
    *chart = best;
    RSV_TRY(rsv_bake_mask_draw(&s->mask, charts, chart));
    take_chart(s, chart->at[0], chart->at[1]);
    *end += RIM;
cleanup:
    return status;
}

rsv_status rsv_bake_pack(rsv_bake_charts *c, float density, uint32_t padding, uint32_t width,
    uint32_t most_rows, uint32_t *height)
{
    rsv_status status;
    sheet s;
    rsv_bake_chart **order = rsv_alloc(c->context, c->count, sizeof *order);
    RSV_TRY(create_sheet(c->context, width, most_rows, padding, &s));
    RSV_TRY(order ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < c->count; k++) {
        size_chart(&c->chart[k], density);
        order[k] = &c->chart[k];
    }
    qsort(order, c->count, sizeof *order, compare_areas);
    *height = 0;
    for (size_t k = 0; k < c->count && *height != UINT32_MAX; k++) {
        uint32_t end;
        RSV_TRY(place(&s, c, order[k], &end));
        *height = end > *height ? end : *height;
    }
cleanup:
    rsv_free(c->context, order);
    destroy_sheet(c->context, &s);
    return status;
}
