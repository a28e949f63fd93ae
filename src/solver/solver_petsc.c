/// KSP of PETSc, which a team brings along (src/mpi/krylov.c).
#include "solver_run.h"

const rsv_solver_method rsv_solver_petsc = { .improve = rsv_improve_outside,
    .needs.outside = true };
