#include "emitter_cells.h"

#include "../core/core.h"
#include "lights_internal.h"

#include <stdlib.h>

/// Cells of all triangles at most, unless there are more triangles.
#define MOST_CELLS 4096
/// Within cells, brightness may have this relative variance on the whole; the last of the three where only more cells
/// than closed forms can deal with would do, and then the second is aimed at.
#define EVEN 0.1f
#define NEARLY_EVEN 0.5f
#define UNEVEN 4.0f
/// Halvings from a cell to one of the patches that it is seen by.
#define PATCH_LEVELS 3

/// The cells, of which those that may be divided are a heap, the one with the greatest urge on top.
typedef struct division {
    const rsv_scene_view *scene;
    const rsv_bsdf *bsdf;
    const uint32_t *triangle;
    rsv_emitter_cell *cell; ///< [capacity] the heap, and those that are done from the end on
    size_t heap, done, capacity;
    size_t shining;
    double power, urge; ///< sums
} division;

static bool is_before(const rsv_emitter_cell *a, const rsv_emitter_cell *b)
{
    if (a->urge != b->urge) return a->urge > b->urge;
    return a->rank != b->rank ? a->rank < b->rank : a->place < b->place;
}

static void push(division *d, rsv_emitter_cell cell)
{
    size_t at = d->heap++;
    for (; at > 0 && is_before(&cell, &d->cell[(at - 1) / 2]); at = (at - 1) / 2)
        d->cell[at] = d->cell[(at - 1) / 2];
    d->cell[at] = cell;
}

static rsv_emitter_cell pop(division *d)
{
    rsv_emitter_cell top = d->cell[0], last = d->cell[--d->heap];
    size_t at = 0;
    for (size_t child = 1; child < d->heap; child = 2 * at + 1) {
        if (child + 1 < d->heap && is_before(&d->cell[child + 1], &d->cell[child])) child++;
        if (!is_before(&d->cell[child], &last)) break;
        d->cell[at] = d->cell[child];
        at = child;
    }
    d->cell[at] = last;
    return top;
}

/// Relative variance inside the patches of a cell, if it is large: that of the brightest patch, of the brightest patch
/// within it, and so on. Stars in a dark sky look the same to everything much larger than a star.
static float hidden_variance(
    const division *d, uint32_t rank, int level, rsv_emission_spread spread)
{
    float hidden = 1;
    for (level += PATCH_LEVELS; level <= RSV_EMITTER_LEVELS; level += PATCH_LEVELS) {
        uint32_t place = rsv_emitter_place(spread.u, spread.v);
        rsv_emitter_create(d->scene, d->bsdf, d->triangle[rank], level, place, &spread);
        hidden *= 1 + spread.variance;
        if (!(spread.variance > 1)) break;
    }
    return hidden - 1 > UNEVEN ? hidden - 1 : 0;
}

static void add(division *d, uint32_t rank, uint32_t place, uint8_t level)
{
    rsv_emitter_cell cell = { .rank = rank, .place = place, .level = level };
    rsv_emission_spread spread;
    rsv_emitter emitter =
        rsv_emitter_create(d->scene, d->bsdf, d->triangle[rank], level, place, &spread);
    cell.power = (float)rsv_emitter_power(&emitter);
    if (level < RSV_EMITTER_LEVELS && emitter.varies && cell.power > 0)
        cell.urge = cell.power * (spread.variance + hidden_variance(d, rank, level, spread));
    d->power += (double)cell.power;
    d->urge += (double)cell.urge;
    d->shining += cell.power > 0;
    if (cell.urge > 0)
        push(d, cell);
    else
        d->cell[d->capacity - ++d->done] = cell;
}

static void split_first(division *d)
{
    rsv_emitter_cell parent = pop(d);
    d->power -= (double)parent.power;
    d->urge -= (double)parent.urge;
    d->shining--;
    for (uint32_t part = 0; part < 4; part++)
        add(d, parent.rank, parent.place | part << 2 * (RSV_EMITTER_LEVELS - 1 - parent.level),
            parent.level + 1);
}

static bool is_worth_more(const division *d)
{
    if (d->heap == 0 || d->heap + d->done + 3 > d->capacity) return false;
    bool few = d->shining + 3 <= RSV_LOCAL_LIGHTS, many = d->shining > RSV_LOCAL_LIGHTS;
    return d->urge > (double)(few ? EVEN : many ? NEARLY_EVEN : UNEVEN) * d->power;
}

static int compare_places(const void *left, const void *right)
{
    const rsv_emitter_cell *a = left, *b = right;
    if (a->rank != b->rank) return a->rank < b->rank ? -1 : 1;
    return (a->place > b->place) - (a->place < b->place);
}

rsv_status rsv_divide_emitters(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const uint32_t *triangle, size_t count, rsv_emitter_cell **cells, size_t *cell_count)
{
    rsv_context *context = rsv_scene_get_context(scene);
    division d = { .scene = rsv_scene_get_view(scene), .bsdf = bsdf, .triangle = triangle };
    d.capacity = count > MOST_CELLS ? count : MOST_CELLS;
    d.cell = *cells = rsv_alloc(context, d.capacity, sizeof *d.cell);
    if (!d.cell) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++)
        add(&d, (uint32_t)k, 0, 0);
    while (is_worth_more(&d))
        split_first(&d);
    for (size_t k = 0; k < d.done; k++) // the gap between heap and the others is closed
        d.cell[d.heap + k] = d.cell[d.capacity - d.done + k];
    *cell_count = d.heap + d.done;
    qsort(d.cell, *cell_count, sizeof *d.cell, compare_places);
    return RSV_OK;
}
