/// The plug-in for work on several processes: MPI carries what a team shares, PETSc and SLEPc solve.
#ifndef RSV_MPI_PLUG_IN_H
#define RSV_MPI_PLUG_IN_H

#include "../core/team.h"
#include "../solve/krylov.h"

#include <mpi.h>

/// The plug-in's entrance, as rsv_team_open: the processes of the launcher. @param message of a failure, out
RSV_API rsv_status rsv_mpi_join(const char *version, rsv_team **team, char *message);

/// The team's communicator.
MPI_Comm rsv_mpi_communicator(rsv_team *team);

/// PETSc, which starts with the first system, so that runs without it do not pay for it.
extern const struct rsv_krylov_table rsv_krylov_petsc;
/// Ends it if it was started, and says which options were of no use: all of them, if it was not wanted.
void rsv_krylov_end(rsv_team *team);

#endif
