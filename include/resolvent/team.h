/// @file team.h
/// Several processes that share one job, on one machine or many: `mpirun -n 8 resolvent solve ...`.
///
/// All processes run the same program with the same arguments. Each holds the scene, its elements and the fields on them. The
/// rows of G, most of the memory and time, are divided. Processes exchange only exact copies of their results, so results
/// and files do not depend on the number of processes (docs/cluster.md).
///
/// Communication is in a plug-in for MPI that is loaded on demand; the library itself does not depend on MPI.
#ifndef RESOLVENT_TEAM_H
#define RESOLVENT_TEAM_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_MESSAGE_BYTES 1024 ///< of the longest error message

typedef struct rsv_team rsv_team;

/// What the plug-in offers. All but `progress` and `alarm` are collective: every process calls them, in the same order,
/// from the thread that entered the library. Broken lines end the program: there is no process left to report to.
typedef struct rsv_team_table {
    /// Items [begin[r], begin[r + 1]) of `array` are known to process r before, to all afterwards.
    /// @param begin [size + 1]
    void (*share)(rsv_team *team, void *array, size_t item_bytes, const size_t *begin);
    /// Each value becomes its sum over the processes.
    void (*sum)(rsv_team *team, int64_t *value, size_t count);
    /// The largest value of any process.
    int64_t (*largest)(rsv_team *team, int64_t value);
    /// All have what process `from` has.
    void (*copy)(rsv_team *team, uint32_t from, void *data, size_t bytes);
    /// Tells process 0 how far this one is; there, the mean of what was heard last of the same phase.
    double (*progress)(rsv_team *team, const char *phase, double fraction);
    /// Whether any process gave the alarm, as `give` does here: it stops working, and the others had better.
    bool (*alarm)(rsv_team *team, bool give);
    void (*leave)(rsv_team *team);
    /// Solvers and eigenvalues by PETSc and SLEPc (src/solve/krylov.h).
    const struct rsv_krylov_table *krylov;
} rsv_team_table;

struct rsv_team {
    const rsv_team_table *table;
    uint32_t rank, size;            ///< this process, of so many
    bool parted;                    ///< after a failure they no longer talk
    rsv_status failure;             ///< RSV_OK = there was none
    char reason[RSV_MESSAGE_BYTES]; ///< the message that all have agreed on then
    /// Processor seconds of the slowest from meeting to meeting, summed: the critical path.
    double path;
    double met; ///< CPU seconds of the calling thread when they last met
    /// Besides those of the variable PETSC_OPTIONS, or NULL; set before the first solve. On leaving, PETSc lists which of
    /// them were not used.
    const char *petsc_options;
};

/// How many processes a launcher (mpirun, srun) started together, and which of them this is, by what it left in the
/// environment; 1 and 0 if none did.
RSV_API uint32_t rsv_team_launched(uint32_t *rank);

/// Joins the processes of a launcher, or a team of one where there is none.
/// @return RSV_ERROR_UNSUPPORTED if the plug-in is not installed
RSV_API rsv_status rsv_team_join(rsv_team **team);

/// All leave together, after they agreed that their work is done or has failed. @param team NULL is allowed
RSV_API void rsv_team_leave(rsv_team *team);

/// All meet, wherever in the library each of them is: the failure of one is the failure of all, and rsv_last_error() says
/// the same everywhere. To be called with RSV_OK at the end of a run, and with its failure by whoever has one.
/// @param team NULL = alone @param message of the failure; NULL = rsv_last_error()
/// @return `status`, or the failure of the first process that has one
RSV_API rsv_status rsv_team_agree(rsv_team *team, rsv_status status, const char *message);

#ifdef __cplusplus
}
#endif

#endif
