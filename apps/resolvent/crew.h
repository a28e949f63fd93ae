/// This program as one of several that a launcher started together, as in `mpirun -n 8 resolvent solve ...`.
///
/// The first of them speaks: the others print nothing and write no files but their parts.
#ifndef CLI_CREW_H
#define CLI_CREW_H

#include "resolvent/team.h"

/// Joins the others, if a launcher says that there are any. Prints what went wrong; false then.
bool cli_crew_join(void);
/// Joins even alone: for what the plug-in for MPI and PETSc can do. @param petsc_options borrowed
bool cli_crew_join_for_petsc(const char *petsc_options);
/// Leaves with them. @return the exit status: a failure if any of them has failed
int cli_crew_leave(int exit_status);

/// From now on each works for itself, on frames of its own; they meet again when they leave.
void cli_crew_disperse(void);
/// Whether one of the dispersed has failed: what that was is said when all leave.
bool cli_crew_alarmed(void);

/// Those to share work with; NULL = alone.
rsv_team *cli_crew(void);
/// Which of how many this is, whether they share work or not.
uint32_t cli_crew_rank(void);
uint32_t cli_crew_size(void);
/// Tells the others of a failure. @return the message of the first that failed
const char *cli_crew_fail(rsv_status status, const char *message);
/// Whether this is the one that speaks.
bool cli_crew_speaks(void);

#endif
