#include "budget.h"

#include "../core/team.h"

#include <stdio.h>
#include <unistd.h>

/// What elements take while they are made: the coarser ones beside the finer ones, and tables of nodes.
#define MAKING_ELEMENTS 3
/// Bytes per triangle of elements on a mesh that needs no splits.
#define BYTES_PER_TRIANGLE 150
/// Bytes per cell of a level in the making.
#define BYTES_PER_CELL 250
/// Part of the memory left that is planned for: the rest is for what no plan foresees.
#define PLANNED 0.85
/// Part of it for the levels of direct light and caustics.
#define LEVELS 0.3
/// Rows of fewer rays are noisier than larger elements are wrong.
#define FEWEST_RAYS 256

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

rsv_status rsv_budget_open(rsv_solution *s)
{
    if (s->desc.max_bytes == 0) return RSV_OK;
    size_t resident = (size_t)rsv_team_largest(s->context, (double)resident_bytes());
    size_t most = s->desc.max_bytes;
    double left = most > resident ? PLANNED * (double)(most - resident) : 0;
    double mesh = (double)BYTES_PER_TRIANGLE * (double)s->scene.view->triangle_count;
    s->bytes_left = (size_t)left;
    if (left > mesh * MAKING_ELEMENTS) return RSV_OK;
    return rsv_fail(RSV_ERROR_MEMORY,
        "solve: a memory budget of %.0f MiB is too small: the scene takes %.0f MiB and its "
        "elements at least %.0f MiB more; allow that or simplify its meshes",
        mebibytes((double)most), mebibytes((double)resident),
        mebibytes(mesh * MAKING_ELEMENTS / PLANNED) + 1);
}

/// Largest size of an entry: ends behind coats, tints and media carry a colour, escapes a bin.
static size_t entry_bytes(const rsv_solution *s)
{
    bool tinted = false;
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        tinted = tinted || s->bsdf[m].coated || !s->bsdf[m].lambert;
    return sizeof(uint32_t) + (tinted ? sizeof(rsv_rgb) : 0);
}

/// What the elements in hand take beside rows: themselves, and fields on them.
static double element_bytes(const rsv_solution *s)
{
    double fields = (double)(RSV_KEPT_ORDERS + 16) * sizeof(rsv_rgb);
    return MAKING_ELEMENTS * (double)rsv_elements_bytes(s->elements) +
           fields * (double)s->elements->node_count;
}

size_t rsv_budget_rows(const rsv_solution *s)
{
    size_t rows = s->desc.max_elements ? s->desc.max_elements : SIZE_MAX;
    if (s->desc.max_bytes == 0) return rows;
    double left = (1 - LEVELS) * (double)s->bytes_left - element_bytes(s);
    double affordable = left / (double)(s->desc.rays_per_element * entry_bytes(s));
    if (affordable < 0) return 0;
    return affordable < (double)rows ? (size_t)affordable : rows;
}

bool rsv_budget_halve_rays(rsv_solution *s)
{
    size_t rows = s->desc.max_elements ? s->desc.max_elements : SIZE_MAX;
    if (rsv_solution_rows(s) > rows || s->desc.rays_per_element <= FEWEST_RAYS) return false;
    s->desc.rays_per_element /= 2;
    return true;
}

size_t rsv_budget_cells(const rsv_solution *s)
{
    if (s->desc.max_bytes == 0) return SIZE_MAX;
    return (size_t)(LEVELS * (double)s->bytes_left / BYTES_PER_CELL);
}

rsv_status rsv_budget_refuse(const rsv_solution *s, size_t rows)
{
    if (s->desc.max_elements && rows > s->desc.max_elements)
        return rsv_fail(RSV_ERROR_MEMORY,
            "solve: a budget of %zu elements is too small: the surfaces of this scene take %zu at "
            "the least; allow as many",
            s->desc.max_elements, rows);
    return rsv_fail(RSV_ERROR_MEMORY,
        "solve: a memory budget of %.0f MiB is too small: %zu rows of %u rays and their elements "
        "take %.0f MiB more; allow that",
        mebibytes((double)s->desc.max_bytes), rows, s->desc.rays_per_element,
        mebibytes((element_bytes(s) +
                      (double)rows * (double)(s->desc.rays_per_element * entry_bytes(s))) /
                      ((1 - LEVELS) * PLANNED) -
                  (double)s->bytes_left / PLANNED) +
            1);
}

void rsv_budget_report(const rsv_solution *s, float wanted)
{
    bool coarser = s->elements->spacing > 1.001f * wanted;
    if (!coarser && s->desc.rays_per_element == s->wanted_rays) return;
    rsv_log(s->context, RSV_LOG_WARNING,
        "solve: coarser than asked for, to keep the budget: %zu elements %.3g m apart instead of "
        "%.3g m, rows of %u rays instead of %u",
        rsv_solution_rows(s), s->elements->spacing, wanted, s->desc.rays_per_element,
        s->wanted_rays);
}

size_t rsv_solution_rows(const rsv_solution *s)
{
    size_t rows = 0;
    for (size_t n = 0; n < s->elements->node_count; n++)
        rows += s->valid_points[n] != 0;
    return rows;
}

static size_t level_bytes(const rsv_elements *elements, size_t fields)
{
    if (!elements) return 0;
    return rsv_elements_bytes(elements) + fields * elements->node_count * sizeof(rsv_rgb);
}

size_t rsv_solution_bytes(const rsv_solution *s)
{
    return level_bytes(s->elements, 1) + s->elements->node_count * sizeof *s->valid_points +
           rsv_transport_bytes(s->transport) + rsv_subsurface_bytes(s->subsurface) +
           level_bytes(s->fine.elements, 1) + level_bytes(s->caustics.elements, 1) +
           level_bytes(s->diffused.elements, 1);
}
