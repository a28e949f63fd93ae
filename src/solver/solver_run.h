/// Data and functions shared by running solvers; only for src/solver.
#ifndef RSV_SOLVER_RUN_H
#define RSV_SOLVER_RUN_H

#include "columns.h"
#include "linear_solver.h"

typedef struct rsv_solver_run {
    const rsv_linear_map *map;
    const rsv_linear_desc *desc;
    rsv_field_shape shape;
    double *source_size; ///< [columns] max |source|
    double *goal;        ///< [columns] max |residual| that is good enough
    double *size;        ///< [columns] max |residual| as known now
    double applications;
    double best;       ///< smallest excess over the goal in this cycle
    uint32_t waiting;  ///< checks since it was found
    bool broke_down;   ///< a solver divided by nothing
    bool blew_up;      ///< residuals grew beyond all sense
    void *kept;        ///< the solver's own, from one cycle to the next; NULL at first
    rsv_status status; ///< of the progress callback
} rsv_solver_run;

/// The interface of solver_NAME.c, as rsv_solver_NAME. The build creates the table of them: src/CMakeLists.txt.
typedef struct rsv_solver_method {
    /// Finds a correction: (I - A) correction close to `residual`.
    /// @param residual free to overwrite; 0 in columns that have converged; sizes are in run->size
    /// @param correction 0 before
    rsv_status (*improve)(rsv_solver_run *run, float *residual, float *correction);
    rsv_solver_needs needs;
    void (*forget)(void *kept); ///< frees run->kept, which is not NULL; NULL = there is never any
} rsv_solver_method;

/// By the `correct` of the map.
rsv_status rsv_improve_outside(rsv_solver_run *run, float *residual, float *correction);

/// image = A field, counted.
void rsv_run_apply(rsv_solver_run *run, const float *field, float *image);

/// A field of the run's shape, zero; NULL when memory runs out.
float *rsv_run_field(const rsv_solver_run *run);
/// A number per column, zero.
double *rsv_run_numbers(const rsv_solver_run *run, size_t count);

/// Whether a column still needs work, by run->size.
static inline bool rsv_run_active(const rsv_solver_run *run, size_t column)
{
    return run->size[column] > run->goal[column];
}

/// Reports the sizes in run->size to the observer. @return whether the cycle should continue
bool rsv_run_goes_on(rsv_solver_run *run);

#endif
