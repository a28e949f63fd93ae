/// @file team.h
/// Several processes that share one job, on one machine or many: `mpirun -n 8 resolvent solve ...`.
///
/// All processes run the same program with the same arguments. Each holds the scene, its elements and the fields on
/// them. The rows of G, which take most of the memory and time, are divided among them. Processes exchange only exact
/// copies of their results, so results and files do not depend on the number of processes (docs/cluster.md).
///
/// Communication is in an MPI plug-in that is loaded on demand. The library itself does not depend on MPI.
#ifndef RESOLVENT_TEAM_H
#define RESOLVENT_TEAM_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_MESSAGE_BYTES 1024 ///< size of the longest error message

typedef struct rsv_team rsv_team;

/// Functions of the plug-in. All except `progress` and `alarm` are collective: every process calls them, in the same
/// order, from the thread that entered the library. A lost connection ends the program.
typedef struct rsv_team_table {
    /// Process r provides the items [begin[r], begin[r + 1]) of `array`; afterwards all processes have all items.
    /// @param begin [size + 1]
    void (*share)(rsv_team *team, void *array, size_t item_bytes, const size_t *begin);
    /// Replaces each value by its sum over the processes.
    void (*sum)(rsv_team *team, int64_t *value, size_t count);
    /// Largest value of any process.
    int64_t (*largest)(rsv_team *team, int64_t value);
    /// Copies the data of process `from` to all others.
    void (*copy)(rsv_team *team, uint32_t from, void *data, size_t bytes);
    /// Reports this process's progress to process 0. There, returns the mean of the last reports of the same phase.
    double (*progress)(rsv_team *team, const char *phase, double fraction);
    /// Whether any process has raised the alarm. `give` raises it: this process stops working, and the others should
    /// too.
    bool (*alarm)(rsv_team *team, bool give);
    void (*leave)(rsv_team *team);
    /// Solvers and eigenvalues by PETSc and SLEPc (src/solve/krylov.h).
    const struct rsv_krylov_table *krylov;
} rsv_team_table;

struct rsv_team {
    const rsv_team_table *table;
    uint32_t rank, size;            ///< number of this process, and of all processes
    bool parted;                    ///< after a failure: they no longer communicate
    rsv_status failure;             ///< RSV_OK = none
    char reason[RSV_MESSAGE_BYTES]; ///< error message, the same in all processes
    /// CPU seconds of the slowest process between synchronisations, summed: the critical path.
    double path;
    double met; ///< CPU seconds of the calling thread at the last synchronisation
    /// Options in addition to those of the variable PETSC_OPTIONS, or NULL; set them before the first solve. At the
    /// end, PETSc lists unused options.
    const char *petsc_options;
};

/// Number of processes that a launcher (mpirun, srun) started together, from its environment variables; 1 without a
/// launcher.
/// @param rank out: number of this process; 0 without a launcher
RSV_API uint32_t rsv_team_launched(uint32_t *rank);

/// Joins the processes of a launcher, or forms a team of one process.
/// @return RSV_ERROR_UNSUPPORTED if the plug-in is not installed
RSV_API rsv_status rsv_team_join(rsv_team **team);

/// Leaves the team. All processes leave together, after agreeing that their work is done or has failed.
/// @param team NULL is allowed
RSV_API void rsv_team_leave(rsv_team *team);

/// Synchronises the outcome of all processes, wherever in the library they are: if one fails, all fail, with the same
/// rsv_last_error(). Call it with RSV_OK at the end of a run, and with the error of a process as soon as it has one.
/// @param team NULL = a single process
/// @param message of the error; NULL = rsv_last_error()
/// @return `status`, or the error of the first process that has one
RSV_API rsv_status rsv_team_agree(rsv_team *team, rsv_status status, const char *message);

#ifdef __cplusplus
}
#endif

#endif
