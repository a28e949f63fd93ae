#include "bake_grid_open.h"

#include "../core/parallel.h"
#include "../core/vec.h"
#include "bake_constants.h"

#include <string.h>

typedef rsv_bake_grid_open grid_open;

#define ALL_PLACES 0xffffu

// ---- looking around -------------------------------------------------------------------------------

/// Patches in even columns and rows look first, and those at the end of a row or column of their group.
static bool leads(const grid_open *q, size_t k)
{
    const rsv_bake_grid *grid = q->grid;
    uint32_t x = (uint32_t)(k % grid->width), y = (uint32_t)(k / grid->width);
    bool last = x + 1 >= grid->width || grid->group[k + 1] != grid->group[k];
    bool lowest = y + 1 >= grid->height || grid->group[k + grid->width] != grid->group[k];
    return (x % 2 == 0 || last) && (y % 2 == 0 || lowest);
}

typedef struct look_job {
    const grid_open *open;
    uint8_t *covered; ///< [count] whether the first place of those that look first is
} look_job;

static void look_first(void *job, rsv_span span)
{
    const grid_open *q = ((const look_job *)job)->open;
    uint8_t *covered = ((const look_job *)job)->covered;
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_bake_patch patch;
        if (q->grid->group[k] == RSV_NONE || !leads(q, k) || rsv_cancelled(q->context)) continue;
        q->grid->patch(q->grid->user, k, &patch);
        covered[k] = patch.count > 0 && rsv_bake_is_covered(&q->cover, &patch.place[0]);
    }
}

/// How many of those around a patch that looked first are covered, and how many are not.
static void count_around(const grid_open *q, const uint8_t *covered, size_t at, uint32_t count[2])
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(at % grid->width), y = (long)(at / grid->width);
    count[0] = count[1] = 0;
    for (long b = y - 2; b <= y + 2; b++)
        for (long a = x - 2; a <= x + 2; a++) {
            if (a < 0 || b < 0 || a >= (long)grid->width || b >= (long)grid->height) continue;
            size_t n = (size_t)b * grid->width + (size_t)a;
            if (grid->group[n] == grid->group[at] && leads(q, n)) count[covered[n]]++;
        }
}

static void look_closer(void *job, rsv_span span)
{
    const grid_open *q = ((const look_job *)job)->open;
    const uint8_t *first = ((const look_job *)job)->covered;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t around[2];
        rsv_bake_patch patch;
        if (q->grid->group[k] == RSV_NONE || rsv_cancelled(q->context)) continue;
        count_around(q, first, k, around);
        if (around[1] == 0) continue;
        q->covered[k] = ALL_PLACES;
        if (around[0] == 0) continue;
        q->grid->patch(q->grid->user, k, &patch);
        q->covered[k] = rsv_bake_covered_places(&q->cover, &patch);
        if (q->covered[k] == (1u << patch.count) - 1) q->covered[k] = ALL_PLACES;
    }
}

// ---- standing in ----------------------------------------------------------------------------------

/// Hands a stand-in on to a neighbour that has none. @return entries of the queue
static size_t hand_on(grid_open *q, size_t from, long dx, long dy, uint32_t *queue, size_t count)
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(from % grid->width) + dx, y = (long)(from / grid->width) + dy;
    if (x < 0 || y < 0 || x >= (long)grid->width || y >= (long)grid->height) return count;
    size_t to = (size_t)y * grid->width + (size_t)x;
    if (grid->group[to] != grid->group[from] || q->stand_in[to] != RSV_NONE) return count;
    q->stand_in[to] = q->stand_in[from];
    queue[count] = (uint32_t)to;
    return count + 1;
}

/// Spreads from the patches in the open, one step at a time.
static void spread(grid_open *q, uint32_t *queue)
{
    size_t count = 0;
    for (size_t k = 0; k < q->count; k++) {
        bool open = q->grid->group[k] != RSV_NONE && q->covered[k] != ALL_PLACES;
        q->stand_in[k] = open ? (uint32_t)k : RSV_NONE;
        if (open) queue[count++] = (uint32_t)k;
    }
    for (size_t k = 0; k < count; k++) {
        count = hand_on(q, queue[k], 1, 0, queue, count);
        count = hand_on(q, queue[k], -1, 0, queue, count);
        count = hand_on(q, queue[k], 0, 1, queue, count);
        count = hand_on(q, queue[k], 0, -1, queue, count);
    }
}

/// Surfaces that are covered all over are lit as they are.
static void settle(grid_open *q)
{
    for (size_t k = 0; k < q->count; k++) {
        bool alone = q->grid->group[k] != RSV_NONE && q->stand_in[k] == RSV_NONE;
        if (alone) q->covered[k] = 0;
        if (alone) q->stand_in[k] = (uint32_t)k;
        q->group[k] = q->covered[k] == ALL_PLACES ? RSV_NONE : q->grid->group[k];
    }
}

rsv_status rsv_bake_grid_open_create(
    const rsv_light_view *s, const rsv_bake_grid *grid, rsv_bake_grid_open *q)
{
    rsv_status status;
    *q = (grid_open){ .context = s->context,
        .s = s,
        .grid = grid,
        .cover = rsv_bake_cover_of(s),
        .count = (size_t)grid->width * grid->height };
    uint8_t *first = rsv_alloc(s->context, q->count, 1);
    uint32_t *queue = rsv_alloc(s->context, q->count, sizeof *queue);
    q->covered = rsv_alloc(s->context, q->count, sizeof *q->covered);
    q->group = rsv_alloc(s->context, q->count, sizeof *q->group);
    q->stand_in = rsv_alloc(s->context, q->count, sizeof *q->stand_in);
    RSV_TRY(first && queue && q->covered && q->group && q->stand_in ? RSV_OK : RSV_ERROR_MEMORY);
    look_job job = { q, first };
    rsv_parallel_for(s->context, q->count, 256, look_first, &job);
    rsv_parallel_for(s->context, q->count, 256, look_closer, &job);
    spread(q, queue);
    settle(q);
    status = rsv_cancelled(s->context) ? RSV_ERROR_CANCELLED : RSV_OK;
cleanup:
    rsv_free(s->context, first);
    rsv_free(s->context, queue);
    return status;
}

void rsv_bake_grid_open_destroy(rsv_bake_grid_open *q)
{
    if (!q->context) return;
    rsv_free(q->context, q->covered);
    rsv_free(q->context, q->group);
    rsv_free(q->context, q->stand_in);
    *q = (grid_open){ .context = NULL };
}

void rsv_bake_grid_open_fill(const rsv_bake_grid_open *q, rsv_rgb *light)
{
    for (size_t k = 0; k < q->count; k++)
        if (q->stand_in[k] != RSV_NONE && q->stand_in[k] != k) light[k] = light[q->stand_in[k]];
}
