#include "budget_fill.h"

#include "../elements/elements.h"
#include "../elements/follower.h"
#include "budget.h"
#include "coarse_elements.h"
#include "pilot.h"
#include "solve_constants.h"

#include <stdlib.h>

/// Elements that a split adds if none of its neighbours is split: the first guess.
#define NODES_PER_LONE_SPLIT 3

typedef struct large_cell {
    float area;
    uint32_t cell;
} large_cell;

/// The largest first.
static int compare_cells(const void *left, const void *right)
{
    const large_cell *a = left, *b = right;
    if (a->area != b->area) return a->area < b->area ? 1 : -1;
    return (a->cell > b->cell) - (a->cell < b->cell);
}

/// Cells that may be split. @return how many
static size_t list_cells(const rsv_elements *e, float wanted, large_cell *list)
{
    size_t count = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        float area = rsv_cell_area(e, c);
        if (e->cell[c].level < RSV_MAX_LEVEL && sqrtf(2 * area) > wanted && !rsv_cell_follows(e, c))
            list[count++] = (large_cell){ area, c };
    }
    qsort(list, count, sizeof *list, compare_cells);
    return count;
}

static bool fits(const rsv_builder *b)
{
    return rsv_budget_elements(b) <= b->desc.max_elements &&
           rsv_builder_rows(b) <= rsv_budget_rows(b) && rsv_builder_rows(b) > 0;
}

/// Splits the largest cells. @param most of them @param split out: how many were; 0 = those would not fit
static rsv_status split_largest(rsv_builder *b, float wanted, size_t most, size_t *split)
{
    rsv_status status;
    bool kept = false;
    size_t cells = b->elements->cell_count;
    large_cell *list = rsv_reserve(b->context, cells, sizeof *list);
    uint8_t *marked = rsv_alloc(b->context, cells, 1);
    RSV_TRY(list && marked ? RSV_OK : RSV_ERROR_MEMORY);
    size_t count = list_cells(b->elements, wanted, list);
    if (count > most) count = most;
    for (size_t k = 0; k < count; k++)
        marked[list[k].cell] = 1;
    if (count) RSV_TRY(rsv_coarse_elements_try(b, marked, fits, &kept));
    *split = kept ? count : 0;
cleanup:
    rsv_free(b->context, list);
    rsv_free(b->context, marked);
    return status;
}

rsv_status rsv_budget_fill(rsv_builder *b, float wanted)
{
    size_t budget = b->desc.max_elements;
    double per_split = NODES_PER_LONE_SPLIT;
    if (budget == 0 || rsv_pilot_has_goal(b) || rsv_builder_rows(b) == 0) return RSV_OK;
    for (int round = 0; round < FILL_ROUNDS; round++) {
        size_t before = rsv_budget_elements(b), split;
        size_t most = (size_t)((double)(budget - before) / per_split);
        if ((double)before >= BUDGET_FILLED * (double)budget || most == 0) break;
        rsv_status status = split_largest(b, wanted, most, &split);
        if (status != RSV_OK) return status;
        size_t added = rsv_budget_elements(b) - before;
        if (split == 0)
            per_split *= 2;
        else if (added > 0)
            per_split = 1.1 * (double)added / (double)split;
    }
    return RSV_OK;
}
