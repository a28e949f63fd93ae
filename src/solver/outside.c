/// Corrections by a solver that the map brings along, such as PETSc's or one on a device.
#include "solver_run.h"

#include <math.h>

/// It measures residuals by length, we by their largest value: part of the wanted reduction that it is asked for.
#define SAFETY 0.2

rsv_status rsv_improve_outside(rsv_solver_run *run, float *residual, float *correction)
{
    double reduction = 1, applications = run->desc->max_applications - run->applications;
    bool converged = false;
    for (size_t c = 0; c < run->shape.columns; c++)
        if (rsv_run_active(run, c)) reduction = fmin(reduction, run->goal[c] / run->size[c]);
    rsv_status status = run->map->table->correct(run->map->data, run->shape.columns, residual,
        SAFETY * reduction, correction, &applications, &converged);
    run->applications += applications;
    run->broke_down = !converged;
    return status;
}
