/// A team of processes over MPI: the plug-in's entrance.
#include "plug_in.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Progress messages are sent at most so often, in seconds.
#define TELL_INTERVAL 0.2
#define PHASE_BYTES 40

/// Of messages to the side.
enum { TAG_PROGRESS, TAG_ALARM };

typedef struct progress_message {
    char phase[PHASE_BYTES];
    double fraction;
} progress_message;

typedef struct mpi_team {
    rsv_team base;
    MPI_Comm job;     ///< collective calls
    MPI_Comm side;    ///< progress
    bool own_mpi;     ///< began here, ends here
    bool alarmed;     ///< has received or sent the alarm
    double told;      ///< MPI_Wtime of the last message
    MPI_Request sent; ///< of a process other than 0: its last message
    progress_message message;
    progress_message *heard; ///< [size] at process 0: the last of each
} mpi_team;

static mpi_team *mpi_of(rsv_team *team) { return (mpi_team *)team; }

MPI_Comm rsv_mpi_communicator(rsv_team *team) { return mpi_of(team)->job; }

/// MPI counts by int: where that is not enough, each process hands its items on in pieces.
static void share_in_pieces(
    mpi_team *m, char *array, size_t item_bytes, const size_t *begin, MPI_Datatype item)
{
    const size_t most = INT_MAX;
    for (uint32_t rank = 0; rank < m->base.size; rank++)
        for (size_t at = begin[rank]; at < begin[rank + 1]; at += most) {
            size_t left = begin[rank + 1] - at;
            MPI_Bcast(
                array + at * item_bytes, (int)(left < most ? left : most), item, (int)rank, m->job);
        }
}

static void share_at_once(mpi_team *m, char *array, const size_t *begin, MPI_Datatype item)
{
    uint32_t size = m->base.size;
    int *count = malloc(2 * (size_t)size * sizeof *count);
    if (!count) {
        MPI_Abort(m->job, 1);
        return;
    }
    int *start = count + size;
    for (uint32_t rank = 0; rank < size; rank++) {
        start[rank] = (int)begin[rank];
        count[rank] = (int)(begin[rank + 1] - begin[rank]);
    }
    MPI_Allgatherv(MPI_IN_PLACE, 0, item, array, count, start, item, m->job);
    free(count);
}

static void share(rsv_team *team, void *array, size_t item_bytes, const size_t *begin)
{
    MPI_Datatype item;
    MPI_Type_contiguous((int)item_bytes, MPI_BYTE, &item);
    MPI_Type_commit(&item);
    if (begin[team->size] > INT_MAX)
        share_in_pieces(mpi_of(team), array, item_bytes, begin, item);
    else
        share_at_once(mpi_of(team), array, begin, item);
    MPI_Type_free(&item);
}

static void sum(rsv_team *team, int64_t *value, size_t count)
{
    for (size_t at = 0; at < count; at += INT_MAX) {
        size_t left = count - at;
        MPI_Allreduce(MPI_IN_PLACE, value + at, left < INT_MAX ? (int)left : INT_MAX, MPI_INT64_T,
            MPI_SUM, mpi_of(team)->job);
    }
}

static int64_t largest(rsv_team *team, int64_t value)
{
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_MAX, mpi_of(team)->job);
    return value;
}

static void copy(rsv_team *team, uint32_t from, void *data, size_t bytes)
{
    for (size_t at = 0; at < bytes; at += INT_MAX) {
        size_t left = bytes - at;
        MPI_Bcast((char *)data + at, left < INT_MAX ? (int)left : INT_MAX, MPI_BYTE, (int)from,
            mpi_of(team)->job);
    }
}

// ---- progress -------------------------------------------------------------------------------------

/// Process 0 receives pending messages.
static void listen(mpi_team *m)
{
    for (int there = 1; there;) {
        MPI_Status from;
        MPI_Iprobe(MPI_ANY_SOURCE, TAG_PROGRESS, m->side, &there, &from);
        if (!there) return;
        MPI_Recv(&m->heard[from.MPI_SOURCE], sizeof *m->heard, MPI_BYTE, from.MPI_SOURCE,
            TAG_PROGRESS, m->side, MPI_STATUS_IGNORE);
    }
}

/// Other processes continue without waiting for their last message to be received, but wait before they send the next.
static void tell(mpi_team *m, const char *phase, double fraction)
{
    int gone = 1;
    double now = MPI_Wtime();
    if (now - m->told < TELL_INTERVAL) return;
    MPI_Test(&m->sent, &gone, MPI_STATUS_IGNORE);
    if (!gone) return;
    m->told = now;
    snprintf(m->message.phase, sizeof m->message.phase, "%s", phase);
    m->message.fraction = fraction;
    MPI_Isend(&m->message, sizeof m->message, MPI_BYTE, 0, TAG_PROGRESS, m->side, &m->sent);
}

static double progress(rsv_team *team, const char *phase, double fraction)
{
    mpi_team *m = mpi_of(team);
    if (team->parted) return fraction;
    if (team->rank > 0) {
        tell(m, phase, fraction);
        return fraction;
    }
    listen(m);
    double total = fraction, count = 1;
    for (uint32_t rank = 1; rank < team->size; rank++) {
        if (strncmp(m->heard[rank].phase, phase, PHASE_BYTES - 1) != 0) continue;
        total += m->heard[rank].fraction;
        count += 1;
    }
    return total / count;
}

// ---- alarm ----------------------------------------------------------------------------------------

/// Sends the alarm once to all, without waiting. It has no content.
static void tell_alarm(mpi_team *m)
{
    for (uint32_t rank = 0; rank < m->base.size; rank++) {
        MPI_Request sent;
        if (rank == m->base.rank) continue;
        MPI_Isend(NULL, 0, MPI_BYTE, (int)rank, TAG_ALARM, m->side, &sent);
        MPI_Request_free(&sent);
    }
}

static bool hear_alarm(mpi_team *m)
{
    for (int there = 1, heard = 0;; heard = 1) {
        MPI_Iprobe(MPI_ANY_SOURCE, TAG_ALARM, m->side, &there, MPI_STATUS_IGNORE);
        if (!there) return heard;
        MPI_Recv(NULL, 0, MPI_BYTE, MPI_ANY_SOURCE, TAG_ALARM, m->side, MPI_STATUS_IGNORE);
    }
}

static bool alarm_all(rsv_team *team, bool give)
{
    mpi_team *m = mpi_of(team);
    if (team->parted) return false;
    bool heard = hear_alarm(m);
    if (give && !heard && !m->alarmed) tell_alarm(m);
    m->alarmed = m->alarmed || give || heard;
    return m->alarmed;
}

// ---- begin and end --------------------------------------------------------------------------------

static void leave(rsv_team *team)
{
    mpi_team *m = mpi_of(team);
    MPI_Request all_here;
    MPI_Wait(&m->sent, MPI_STATUS_IGNORE);
    MPI_Ibarrier(m->job, &all_here);
    for (int here = 0; !here; MPI_Test(&all_here, &here, MPI_STATUS_IGNORE)) {
        if (team->rank == 0) listen(m); // the others' last messages, before they can leave
        hear_alarm(m);
    }
    rsv_krylov_end(team);
    MPI_Comm_free(&m->job);
    MPI_Comm_free(&m->side);
    if (m->own_mpi) MPI_Finalize();
    free(m->heard);
    free(m);
}

static const rsv_team_table table = { share, sum, largest, copy, progress, alarm_all, leave,
    &rsv_krylov_petsc };

/// Begins MPI unless the program did.
static rsv_status begin_mpi(mpi_team *m, char *message)
{
    int begun, rank, size, threads;
    MPI_Initialized(&begun);
    m->own_mpi = !begun;
    if (!begun && MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &threads) != MPI_SUCCESS) {
        snprintf(message, RSV_MESSAGE_BYTES, "MPI cannot be started");
        return RSV_ERROR_UNSUPPORTED;
    }
    MPI_Comm_dup(MPI_COMM_WORLD, &m->job);
    MPI_Comm_dup(MPI_COMM_WORLD, &m->side);
    MPI_Comm_rank(m->job, &rank);
    MPI_Comm_size(m->job, &size);
    m->base = (rsv_team){ .table = &table, .rank = (uint32_t)rank, .size = (uint32_t)size };
    m->sent = MPI_REQUEST_NULL;
    return RSV_OK;
}

RSV_API rsv_status rsv_mpi_join(const char *version, rsv_team **team, char *message)
{
    if (strcmp(version, RSV_VERSION_STRING) != 0) {
        snprintf(message, RSV_MESSAGE_BYTES,
            "the plug-in for MPI and PETSc is of version " RSV_VERSION_STRING
            ", the program of version %s; install both again",
            version);
        return RSV_ERROR_UNSUPPORTED;
    }
    mpi_team *m = calloc(1, sizeof *m);
    rsv_status status = m ? begin_mpi(m, message) : RSV_ERROR_MEMORY;
    if (status == RSV_OK) {
        m->heard = calloc(m->base.size, sizeof *m->heard);
        status = m->heard ? RSV_OK : RSV_ERROR_MEMORY;
    }
    if (status == RSV_OK) {
        *team = &m->base;
        return RSV_OK;
    }
    if (status == RSV_ERROR_MEMORY) snprintf(message, RSV_MESSAGE_BYTES, "out of memory");
    free(m);
    return status;
}
