/// Gauss-Seidel: every row uses the updated values of the rows before it. Rows are divided into a fixed number of
/// blocks, within which they run in parallel, so that the result does not depend on the number of threads. With this
/// many blocks, convergence is that of the textbook method.
#include "solver_run.h"

#include <math.h>

#define BLOCKS 64

/// correction = residual + A correction, block by block. The largest change of a row bounds its remaining residual,
/// because rows of A sum to at most 1; run->size becomes that bound.
static void sweep(rsv_solver_run *run, const float *residual, float *correction, float *scattered,
    float *gathered)
{
    const rsv_linear_map *map = run->map;
    size_t columns = run->shape.columns, block = (map->count + BLOCKS - 1) / BLOCKS;
    map->table->scatter_rows(map->data, columns, correction, 0, map->count, scattered);
    double *change = run->size;
    for (size_t c = 0; c < columns; c++)
        change[c] = 0;
    for (size_t begin = 0; begin < map->count; begin += block) {
        size_t end = begin + block < map->count ? begin + block : map->count;
        map->table->gather_rows(map->data, columns, scattered, begin, end, gathered);
        for (size_t k = begin * columns; k < end * columns; k++) {
            float value = residual[k] + gathered[k];
            double size = fabs((double)value - correction[k]);
            if (!(size <= change[k % columns])) change[k % columns] = size;
            correction[k] = value;
        }
        map->table->scatter_rows(map->data, columns, correction, begin, end, scattered);
    }
    run->applications += 1;
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_status status = RSV_OK;
    float *scattered = rsv_run_field(run), *gathered = rsv_run_field(run);
    if (!scattered || !gathered) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    do
        sweep(run, residual, correction, scattered, gathered);
    while (rsv_run_goes_on(run));
cleanup:
    rsv_free(run->shape.context, scattered);
    rsv_free(run->shape.context, gathered);
    return status;
}

const rsv_solver_method rsv_solver_gauss_seidel = { .improve = improve, .needs.rows = true };
