/// The plug-in for several processes: MPI for communication, PETSc and SLEPc as solvers.
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
/// Ends PETSc if it was started, and names unused options: all of them, if it was not needed.
void rsv_krylov_end(rsv_team *team);

#endif
