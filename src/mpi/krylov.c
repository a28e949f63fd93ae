/// Systems of light transport solved by PETSc's KSP; eigenvalues by SLEPc.
#include "matrix.h"

#include <slepceps.h>
#include <string.h>

struct rsv_krylov {
    rsv_mpi_rows rows;
    Mat matrix;
    KSP solver;
    Vec right, left;
};

// ---- PETSc itself --------------------------------------------------------------------------------

static PetscErrorCode start(rsv_team *team)
{
    PetscBool started;
    PetscCall(SlepcInitialized(&started));
    if (!started) {
        PETSC_COMM_WORLD = rsv_mpi_communicator(team);
        PetscCall(
            PetscOptionsSetValue(NULL, "-no_signal_handler", "true")); // the program has its own
        PetscCall(SlepcInitializeNoArguments());
        if (team->petsc_options) PetscCall(PetscOptionsInsertString(NULL, team->petsc_options));
    }
    return 0;
}

void rsv_krylov_end(rsv_team *team)
{
    PetscBool started;
    PetscInt unused = 0;
    if (team->petsc_options) PetscCallVoid(start(team));
    PetscCallVoid(SlepcInitialized(&started));
    if (!started) return;
    PETSC_STDOUT = stderr;
    PetscCallVoid(PetscOptionsAllUsed(NULL, &unused));
    if (unused) { // as PETSc itself does where it was built for debugging
        PetscCallVoid(
            PetscPrintf(PETSC_COMM_WORLD, "WARNING! There are options you set that were not used!\n"
                                          "WARNING! could be spelling mistake, etc!\n"));
        PetscCallVoid(PetscOptionsLeft(NULL));
    }
    PetscCallVoid(SlepcFinalize());
}

/// The first line of a failure as the message: the rest of PETSc's trace says where in its own sources.
static rsv_status outcome(PetscErrorCode code, char *message)
{
    char *text = NULL;
    *message = '\0';
    if (code == 0) return RSV_OK;
    PetscErrorMessage(code, NULL, &text);
    if (text && *text)
        snprintf(message, RSV_MESSAGE_BYTES, "PETSc: %.*s", (int)strcspn(text, "\n"), text);
    else
        snprintf(message, RSV_MESSAGE_BYTES, "PETSc fails with error %d", (int)code);
    return code == PETSC_ERR_MEM ? RSV_ERROR_MEMORY : RSV_ERROR_ARGUMENT;
}

/// Calls that may fail, and print nothing where they do.
#define OUTCOME_OF(call, message)                                                                  \
    (PetscPushErrorHandler(PetscReturnErrorHandler, NULL), (void)(code = (call)),                  \
        PetscPopErrorHandler(), outcome(code, message))

// ---- solving -------------------------------------------------------------------------------------

static PetscErrorCode create_matrix(rsv_krylov *k, bool *shell)
{
    char type[16] = "shell";
    PetscFunctionBeginUser;
    PetscCall(PetscOptionsGetString(NULL, NULL, "-resolvent_mat_type", type, sizeof type, NULL));
    *shell = strcmp(type, "shell") == 0;
    PetscCheck(*shell || strcmp(type, "aij") == 0, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT,
        "-resolvent_mat_type is '%s'; it must be shell or aij", type);
    if (*shell)
        PetscCall(rsv_mpi_shell_system(&k->rows, &k->matrix));
    else
        PetscCall(rsv_mpi_assembled_system(&k->rows, &k->matrix));
    PetscFunctionReturn(0);
}

static PetscErrorCode create_solver(rsv_krylov *k)
{
    PC preconditioner;
    bool shell = true;
    PetscFunctionBeginUser;
    PetscCall(create_matrix(k, &shell));
    PetscCall(MatCreateVecs(k->matrix, &k->left, &k->right));
    PetscCall(KSPCreate(k->rows.communicator, &k->solver));
    PetscCall(KSPSetOperators(k->solver, k->matrix, k->matrix));
    PetscCall(KSPGetPC(k->solver, &preconditioner));
    if (shell) PetscCall(PCSetType(preconditioner, PCNONE)); // others would look at entries
    PetscCall(KSPSetFromOptions(k->solver));
    PetscFunctionReturn(0);
}

static PetscErrorCode create_parts(const rsv_krylov_system *system, rsv_krylov *k)
{
    PetscCall(start(system->team));
    PetscCall(rsv_mpi_rows_create(system, &k->rows));
    PetscCall(create_solver(k));
    return 0;
}

static void destroy(rsv_krylov *k)
{
    if (!k) return;
    PetscCallVoid(KSPDestroy(&k->solver));
    PetscCallVoid(MatDestroy(&k->matrix));
    PetscCallVoid(VecDestroy(&k->left));
    PetscCallVoid(VecDestroy(&k->right));
    rsv_mpi_rows_destroy(&k->rows);
    free(k);
}

static rsv_status create(const rsv_krylov_system *system, rsv_krylov **krylov, char *message)
{
    PetscErrorCode code;
    rsv_krylov *k = calloc(1, sizeof *k);
    if (!k) return RSV_ERROR_MEMORY;
    rsv_status status = OUTCOME_OF(create_parts(system, k), message);
    if (status == RSV_OK)
        *krylov = k;
    else
        destroy(k);
    return status;
}

static PetscErrorCode run(rsv_krylov *k, const rsv_rgb *residual, double relative,
    rsv_rgb *correction, rsv_krylov_report *report)
{
    PetscBool given;
    PetscInt steps;
    KSPConvergedReason reason;
    PetscFunctionBeginUser;
    PetscCall(rsv_mpi_set(&k->rows, residual, k->right));
    PetscCall(PetscOptionsHasName(NULL, NULL, "-ksp_rtol", &given));
    if (!given)
        PetscCall(
            KSPSetTolerances(k->solver, relative, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
    PetscCall(KSPSolve(k->solver, k->right, k->left));
    PetscCall(KSPGetIterationNumber(k->solver, &steps));
    PetscCall(KSPGetConvergedReason(k->solver, &reason));
    report->applications = (double)steps;
    report->converged = reason > 0;
    PetscCall(rsv_mpi_get(&k->rows, k->left, correction));
    PetscFunctionReturn(0);
}

static rsv_status solve(rsv_krylov *k, const rsv_rgb *residual, double relative,
    rsv_rgb *correction, rsv_krylov_report *report, char *message)
{
    PetscErrorCode code;
    return OUTCOME_OF(run(k, residual, relative, correction, report), message);
}

// ---- eigenvalues ---------------------------------------------------------------------------------

static PetscErrorCode find_eigenvalues(rsv_krylov *k, size_t *count, double *value)
{
    Mat gather;
    EPS solver;
    PetscInt found;
    PetscFunctionBeginUser;
    PetscCall(rsv_mpi_shell_gather(&k->rows, &gather));
    PetscCall(EPSCreate(k->rows.communicator, &solver));
    PetscCall(EPSSetOperators(solver, gather, NULL));
    PetscCall(EPSSetProblemType(solver, EPS_NHEP));
    PetscCall(EPSSetDimensions(solver, (PetscInt)*count, PETSC_DEFAULT, PETSC_DEFAULT));
    PetscCall(EPSSetTolerances(solver, 1e-6, PETSC_DEFAULT));
    PetscCall(EPSSetFromOptions(solver));
    PetscCall(EPSSolve(solver));
    PetscCall(EPSGetConverged(solver, &found));
    if ((size_t)found < *count) *count = (size_t)found;
    for (size_t i = 0; i < *count; i++) {
        PetscScalar real, imaginary;
        PetscCall(EPSGetEigenvalue(solver, (PetscInt)i, &real, &imaginary));
        value[2 * i] = real;
        value[2 * i + 1] = imaginary;
    }
    PetscCall(EPSDestroy(&solver));
    PetscCall(MatDestroy(&gather));
    PetscFunctionReturn(0);
}

static rsv_status eigenvalues(rsv_krylov *k, size_t *count, double *value, char *message)
{
    PetscErrorCode code;
    return OUTCOME_OF(find_eigenvalues(k, count, value), message);
}

static rsv_krylov_traffic traffic(const rsv_krylov *k) { return k->rows.traffic; }

const struct rsv_krylov_table rsv_krylov_petsc = { create, destroy, solve, eigenvalues, traffic };
