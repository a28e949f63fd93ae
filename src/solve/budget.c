#include "budget.h"

#include "../core/team.h"
#include "solve_constants.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

/// Memory that the process occupies now; 0 where the system does not say.
static size_t resident_bytes(void)
{
    size_t total = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file) return 0;
    if (fscanf(file, "%zu %zu", &total, &resident) != 2) resident = 0;
    fclose(file);
    return resident * (size_t)sysconf(_SC_PAGESIZE);
}

static double mebibytes(double bytes) { return bytes / (1 << 20); }

rsv_status rsv_budget_open(rsv_builder *b)
{
    if (b->desc.max_bytes == 0) return RSV_OK;
    size_t resident = (size_t)rsv_team_largest(b->context, (double)resident_bytes());
    size_t most = b->desc.max_bytes;
    resident += BESIDES + b->desc.reserved_bytes;
    double left = most > resident ? PLANNED * (double)(most - resident) : 0;
    double mesh = (double)BYTES_PER_TRIANGLE * (double)b->scene.view->triangle_count;
    b->bytes_left = (size_t)left;
    if (left > mesh * MAKING_ELEMENTS) return RSV_OK;
    return rsv_fail(RSV_ERROR_MEMORY,
        "solve: a memory budget of %.0f MiB is too small: program%s take %.0f MiB and "
        "elements at least %.0f MiB more; allow %.0f MiB or simplify its meshes",
        mebibytes((double)most), b->desc.reserved_bytes ? ", scene and output" : " and scene",
        ceil(mebibytes((double)resident)), ceil(mebibytes(mesh * MAKING_ELEMENTS / PLANNED)),
        ceil(mebibytes((double)resident)) + ceil(mebibytes(mesh * MAKING_ELEMENTS / PLANNED)) + 1);
}

/// Largest size of an entry: ends behind coats, tints and media carry a colour, escapes a bin.
static size_t entry_bytes(const rsv_builder *b)
{
    bool tinted = false;
    for (size_t m = 0; m < b->scene.view->material_count; m++)
        tinted = tinted || b->world->bsdf[m].coated || !b->world->bsdf[m].lambert;
    return sizeof(uint32_t) + (tinted ? sizeof(rsv_rgb) : 0);
}

/// Memory of the present elements besides rows: themselves, and fields on them.
static double element_bytes(const rsv_builder *b)
{
    double fields = (double)(RSV_KEPT_ORDERS + 16) * sizeof(rsv_rgb);
    return MAKING_ELEMENTS * (double)rsv_elements_bytes(b->elements) +
           fields * (double)b->elements->node_count;
}

/// Number of rows within the budget of elements, which also counts hanging and buried ones.
static size_t rows_of_elements(const rsv_builder *b)
{
    if (b->desc.max_elements == 0) return SIZE_MAX;
    size_t counted = rsv_budget_elements(b), rows = rsv_builder_rows(b);
    size_t others = counted > rows ? counted - rows : 0;
    return b->desc.max_elements > others ? b->desc.max_elements - others : 0;
}

size_t rsv_budget_rows(const rsv_builder *b)
{
    size_t rows = rows_of_elements(b);
    if (b->desc.max_bytes == 0) return rows;
    double left = (1 - LEVELS) * (double)b->bytes_left - element_bytes(b);
    double affordable = left / (double)(b->desc.rays_per_element * entry_bytes(b));
    if (affordable < 0) return 0;
    return affordable < (double)rows ? (size_t)affordable : rows;
}

bool rsv_budget_halve_rays(rsv_builder *b)
{
    if (rsv_builder_rows(b) > rows_of_elements(b) || b->desc.rays_per_element <= FEWEST_RAYS)
        return false;
    b->desc.rays_per_element /= 2;
    return true;
}

size_t rsv_budget_cells(const rsv_builder *b)
{
    if (b->desc.max_bytes == 0) return SIZE_MAX;
    return (size_t)(LEVELS * (double)b->bytes_left / BYTES_PER_CELL);
}

rsv_status rsv_budget_refuse(const rsv_builder *b, size_t least)
{
    size_t rows = rsv_builder_rows(b);
    if (b->desc.max_elements && (least > b->desc.max_elements || b->desc.max_bytes == 0))
        return rsv_fail(RSV_ERROR_MEMORY,
            "solve: a budget of %zu elements is too small: the surfaces of this scene need at least %zu; allow "
            "that many",
            b->desc.max_elements, least);
    return rsv_fail(RSV_ERROR_MEMORY,
        "solve: a memory budget of %.0f MiB is too small: %zu rows of %u rays and their elements "
        "take more; allow %.0f MiB",
        mebibytes((double)b->desc.max_bytes), rows, b->desc.rays_per_element,
        ceil(mebibytes((double)b->desc.max_bytes - (double)b->bytes_left / PLANNED +
                       (element_bytes(b) +
                           (double)rows * (double)(b->desc.rays_per_element * entry_bytes(b))) /
                           ((1 - LEVELS) * PLANNED))) +
            1);
}

void rsv_budget_report(const rsv_builder *b, float wanted)
{
    bool coarser = b->elements->spacing > 1.001f * wanted;
    if (!coarser && b->desc.rays_per_element == b->wanted_rays) return;
    rsv_log(b->context, RSV_LOG_WARNING,
        "solve: coarser than requested, to stay within the budget: %zu elements %.3g m apart instead of "
        "%.3g m, rows of %u rays instead of %u",
        rsv_budget_elements(b), b->elements->spacing, wanted, b->desc.rays_per_element,
        b->wanted_rays);
}
