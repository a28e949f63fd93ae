/// Southwell's relaxation: takes the node with the largest residual, moves it into the solution, and shoots it to all
/// nodes that see it. This is progressive radiosity (Cohen et al. 1988; Gortler, Cohen and Slusallek 1994).
///
/// Searching for the largest would cost as much as shooting it. Instead, nodes are visited in order and shoot if they
/// are above a threshold, which then decreases.
#include "solver_run.h"

#include <math.h>
#include <string.h>

/// The threshold as a part of the largest residual.
#define LARGE 0.25

/// A node's residual, where it is worth shooting. @return whether any column is
static bool take_large(const rsv_solver_run *run, float *residual, float *amount)
{
    bool any = false;
    for (size_t c = 0; c < run->shape.columns; c++) {
        double threshold = fmax(LARGE * run->size[c], 0.5 * run->goal[c]);
        if (rsv_run_active(run, c) && fabs((double)residual[c]) > threshold) any = true;
    }
    if (!any) return false;
    memcpy(amount, residual, run->shape.columns * sizeof *amount);
    memset(residual, 0, run->shape.columns * sizeof *residual);
    return true;
}

static void shoot_large(rsv_solver_run *run, float *residual, float *correction, float *amount)
{
    const rsv_linear_map *map = run->map;
    size_t columns = run->shape.columns;
    for (size_t n = 0; n < map->count; n++) {
        if (!take_large(run, residual + n * columns, amount)) continue;
        for (size_t c = 0; c < columns; c++)
            correction[n * columns + c] += amount[c];
        run->applications += map->table->shoot(map->data, columns, n, amount, residual);
    }
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    float *amount = rsv_alloc(run->shape.context, run->shape.columns, sizeof *amount);
    if (!amount) return RSV_ERROR_MEMORY;
    do {
        shoot_large(run, residual, correction, amount);
        rsv_columns_max(&run->shape, residual, run->size);
    } while (rsv_run_goes_on(run));
    rsv_free(run->shape.context, amount);
    return RSV_OK;
}

const rsv_solver_method rsv_solver_southwell = { .improve = improve, .needs.columns = true };
