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

/// NULL = alone.
rsv_team *cli_crew(void);
/// Whether this is the one that speaks.
bool cli_crew_speaks(void);

#endif
