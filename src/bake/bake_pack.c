#include "bake_pack.h"

#include "../core/vec.h"

#include <stdlib.h>
#include <string.h>

static void size_chart(rsv_bake_chart *chart, float density)
{
    for (int axis = 0; axis < 2; axis++) {
        float texels = roundf(chart->size[axis] * density);
        chart->texels[axis] = texels < 2 ? 2 : texels > 65536 ? 65536 : (uint32_t)texels;
    }
}

static int compare_heights(const void *a, const void *b)
{
    const rsv_bake_chart *const *x = a, *const *y = b;
    if ((*x)->texels[1] != (*y)->texels[1]) return (*x)->texels[1] < (*y)->texels[1] ? 1 : -1;
    if ((*x)->texels[0] != (*y)->texels[0]) return (*x)->texels[0] < (*y)->texels[0] ? 1 : -1;
    return (*x > *y) - (*x < *y);
}

/// The upper rim of what has been placed: runs of columns of one height.
typedef struct skyline {
    uint32_t *begin, *top; ///< [count] columns from `begin` to the next run's are taken below `top`
    size_t count;
    uint32_t width;
} skyline;

/// Lowest row from which `width` columns are free, starting with run `k`; UINT32_MAX beyond the map.
static uint32_t rest_on(const skyline *s, size_t k, uint32_t width, uint32_t limit)
{
    uint32_t end = s->begin[k] + width, top = 0;
    if (end > s->width) return UINT32_MAX;
    for (; k < s->count && s->begin[k] < end && top < limit; k++)
        top = s->top[k] > top ? s->top[k] : top;
    return top;
}

/// Raises columns [x, x + width), which begin with run `k`, to `top`.
static void raise_columns(skyline *s, size_t k, uint32_t x, uint32_t width, uint32_t top)
{
    uint32_t end = x + width, under = 0;
    size_t next = k;
    while (next < s->count && s->begin[next] < end)
        under = s->top[next++];
    bool rest = (next < s->count ? s->begin[next] : s->width) > end;
    size_t kept = k + 1 + rest, tail = s->count - next;
    memmove(s->begin + kept, s->begin + next, tail * sizeof *s->begin);
    memmove(s->top + kept, s->top + next, tail * sizeof *s->top);
    s->begin[k] = x;
    s->top[k] = top;
    if (rest) {
        s->begin[k + 1] = end;
        s->top[k + 1] = under;
    }
    s->count = kept + tail;
}

/// Puts a chart where it lies lowest. @return the row above it
static uint32_t place(rsv_bake_chart *chart, skyline *s, uint32_t padding)
{
    uint32_t width = chart->texels[0] + padding, best = UINT32_MAX;
    size_t run = 0;
    for (size_t k = 0; k < s->count; k++) {
        if (s->top[k] >= best) continue;
        uint32_t row = rest_on(s, k, width, best);
        if (row < best) best = row, run = k;
    }
    chart->at[0] = s->begin[run] + padding;
    chart->at[1] = best + padding;
    raise_columns(s, run, s->begin[run], width, best + chart->texels[1] + padding);
    return chart->at[1] + chart->texels[1] + padding;
}

rsv_status rsv_bake_pack(rsv_bake_charts *c, float density, uint32_t padding, uint32_t width,
    uint32_t most_rows, uint32_t *height)
{
    rsv_status status = RSV_OK;
    rsv_bake_chart **order = rsv_alloc(c->context, c->count, sizeof *order);
    skyline s = { .begin = rsv_alloc(c->context, c->count + 2, sizeof *s.begin),
        .top = rsv_alloc(c->context, c->count + 2, sizeof *s.top),
        .count = 1,
        .width = width - padding };
    RSV_TRY(order && s.begin && s.top ? RSV_OK : RSV_ERROR_MEMORY);
    *height = 0;
    for (size_t k = 0; k < c->count; k++) {
        size_chart(&c->chart[k], density);
        if (c->chart[k].texels[0] + padding > s.width) *height = UINT32_MAX;
        order[k] = &c->chart[k];
    }
    qsort(order, c->count, sizeof *order, compare_heights);
    for (size_t k = 0; k < c->count && *height <= most_rows; k++) {
        uint32_t end = place(order[k], &s, padding);
        *height = end > *height ? end : *height;
    }
    if (*height > most_rows) *height = UINT32_MAX;
cleanup:
    rsv_free(c->context, order);
    rsv_free(c->context, s.begin);
    rsv_free(c->context, s.top);
    return status;
}
