/// Corrections by a solver that the map brings along, such as PETSc's or one on a device.
#include "solver_run.h"

#include <math.h>

/// Fraction of the target reduction to request, because it measures residuals by length, and we by their largest value.
#define SAFETY 0.2

rsv_status rsv_improve_outside(rsv_solver_run *run, float *residual, float *correction)
{
    double reduction = 1;
    for (size_t c = 0; c < run->shape.columns; c++)
        if (rsv_run_active(run, c)) reduction = fmin(reduction, run->goal[c] / run->size[c]);
    rsv_correction wanted = { .relative = SAFETY * reduction,
        .applications = run->desc->max_applications - run->applications };
    rsv_status status =
        run->map->table->correct(run->map->data, run->shape.columns, residual, &wanted, correction);
    run->applications += wanted.applications;
    run->broke_down = !wanted.converged;
    return status;
}
