/// This program as one of several that a launcher started together, as in `mpirun -n 8 resolvent solve ...`.
///
/// The first of them speaks: the others print nothing and write no files but their parts.
#ifndef CLI_CREW_H
#define CLI_CREW_H

#include "resolvent/team.h"

/// Joins the other processes if a launcher says that there are any. Prints an error and returns false on failure.
bool cli_crew_join(void);
/// Joins even without other processes, to use the plug-in for MPI and PETSc. @param petsc_options borrowed
bool cli_crew_join_for_petsc(const char *petsc_options);
/// Leaves the team. @return the exit status: a failure if any process failed
int cli_crew_leave(int exit_status);

/// From now on each process renders frames of its own; they synchronise again when they leave.
void cli_crew_disperse(void);
/// Whether a process has failed since they dispersed. The error is printed when all leave.
bool cli_crew_alarmed(void);

/// The team to share work with; NULL = this process is alone.
rsv_team *cli_crew(void);
/// This process's number among all launched ones, whether they share work or not.
uint32_t cli_crew_rank(void);
uint32_t cli_crew_size(void);
/// Tells the other processes of a failure. @return the message of the first that failed
const char *cli_crew_fail(rsv_status status, const char *message);
/// Whether this is the one that speaks.
bool cli_crew_speaks(void);

#endif
