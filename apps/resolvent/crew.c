#include "crew.h"

#include "command.h"

#include <stdio.h>
#include <unistd.h>

/// Belongs to the process, as MPI does.
static rsv_team *crew;

static bool dispersed;

rsv_team *cli_crew(void) { return dispersed ? NULL : crew; }

void cli_crew_disperse(void) { dispersed = true; }

/// @param give this one has failed
static bool alarm_others(bool give)
{
    return crew && crew->size > 1 && !crew->parted && crew->table->alarm(crew, give);
}

bool cli_crew_alarmed(void) { return alarm_others(false); }

uint32_t cli_crew_rank(void) { return crew ? crew->rank : 0; }

uint32_t cli_crew_size(void) { return crew ? crew->size : 1; }

const char *cli_crew_fail(rsv_status status, const char *message)
{
    if (dispersed) alarm_others(true);
    if (crew && !crew->parted) rsv_team_agree(crew, status, message);
    return crew && crew->parted ? rsv_last_error() : message;
}

bool cli_crew_speaks(void)
{
    uint32_t rank;
    if (crew) return crew->rank == 0;
    rsv_team_launched(&rank);
    return rank == 0;
}

/// A process that cannot join cannot tell the others. The first process prints errors that all have; any other one
/// waits, since the launcher ends it together with the first, and prints its error only if it is still running.
static bool join(void)
{
    uint32_t rank, size = rsv_team_launched(&rank);
    if (rsv_team_join(&crew) == RSV_OK) return true;
    if (rank == 0) {
        fprintf(stderr, "error: %s\n", rsv_last_error());
        return false;
    }
    sleep(2);
    fprintf(stderr, "error: process %u of %u: %s\n", rank, size, rsv_last_error());
    return false;
}

bool cli_crew_join(void)
{
    uint32_t rank;
    if (rsv_team_launched(&rank) == 1) return true;
    if (!join()) return false;
    return crew->rank == 0 || freopen("/dev/null", "w", stdout) != NULL;
}

bool cli_crew_join_for_petsc(const char *petsc_options)
{
    if (!crew && !join()) return false;
    crew->petsc_options = petsc_options;
    return true;
}

int cli_crew_leave(int exit_status)
{
    if (!crew) return exit_status;
    bool parted = crew->parted;
    rsv_status status = exit_status == CLI_SUCCESS ? RSV_OK : RSV_ERROR_ARGUMENT;
    status = rsv_team_agree(crew, status, "");
    if (status != RSV_OK && exit_status == CLI_SUCCESS) {
        if (!parted && crew->rank == 0) fprintf(stderr, "error: %s\n", rsv_last_error());
        exit_status = CLI_FAILURE;
    }
    if (exit_status != CLI_SUCCESS) crew->petsc_options = NULL; // no matter which were used
    rsv_team_leave(crew);
    crew = NULL;
    return exit_status;
}
