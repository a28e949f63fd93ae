#include "team.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLUG_IN "libresolvent_mpi.so"

static uint32_t number_of(const char *variable)
{
    const char *text = getenv(variable);
    return text ? (uint32_t)strtoul(text, NULL, 10) : 0;
}

uint32_t rsv_team_launched(uint32_t *rank)
{
    static const char *const names[][2] = { { "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK" },
        { "PMI_SIZE", "PMI_RANK" } };
    *rank = 0;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        uint32_t size = number_of(names[k][0]);
        if (size < 2) continue;
        *rank = number_of(names[k][1]);
        return size;
    }
    return 1;
}

rsv_status rsv_team_join(rsv_team **team)
{
    char message[RSV_MESSAGE_BYTES] = "";
    void *library = dlopen(PLUG_IN, RTLD_NOW | RTLD_GLOBAL); // MPI's own plug-ins look for it there
    if (!library)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "several processes, and PETSc, need the plug-in " PLUG_IN
            ", which is in the package resolvent-mpi, and built where MPI, PETSc and SLEPc are "
            "installed (./dev cluster): %s",
            dlerror());
    rsv_team_open open = (rsv_team_open)dlsym(library, RSV_TEAM_OPEN);
    if (!open)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            PLUG_IN " belongs to another version of this program; install it "
                    "again");
    rsv_status status = open(rsv_version(), team, message);
    return status == RSV_OK ? RSV_OK : rsv_fail(status, "%s", message);
}

void rsv_team_leave(rsv_team *team)
{
    if (team) team->table->leave(team);
}

/// One number holds two values: the failure in the upper bits, and the time taken to get here below them.
#define TIME_BITS 40 // of microseconds: twelve days
#define RANK_BITS 18
#define STATUS_BITS 4

/// The first process that fails has the largest key. Processes that were only asked to stop come last: they do not know
/// why.
static int64_t failure_key(const rsv_team *team, rsv_status status)
{
    int64_t rank_key = (int64_t)(team->size - team->rank) << STATUS_BITS;
    if (status == RSV_OK) return 0;
    return ((int64_t)(status != RSV_ERROR_CANCELLED) << (RANK_BITS + STATUS_BITS)) + rank_key +
           (int64_t)status;
}

/// @return the largest key of any process; the slowest prolongs the critical path
static int64_t meet(rsv_team *team, int64_t key)
{
    const int64_t time_mask = ((int64_t)1 << TIME_BITS) - 1;
    int64_t microseconds = (int64_t)(1e6 * (rsv_thread_seconds() - team->met));
    int64_t largest = team->table->largest(team, (key << TIME_BITS) + (microseconds & time_mask));
    team->path += 1e-6 * (double)(largest & time_mask);
    team->met = rsv_thread_seconds();
    return largest >> TIME_BITS;
}

rsv_status rsv_team_agree(rsv_team *team, rsv_status status, const char *reason)
{
    if (!team || team->size == 1) return status;
    // failures after the first are not reported
    if (team->parted && team->failure != RSV_OK && status != RSV_OK)
        return rsv_fail(team->failure, "%s", team->reason);
    if (team->parted) return status;
    int64_t worst = meet(team, failure_key(team, status));
    if (worst == 0) return RSV_OK;
    uint32_t failed =
        team->size - (uint32_t)(worst >> STATUS_BITS & (((int64_t)1 << RANK_BITS) - 1));
    rsv_status failure = (rsv_status)(worst & ((1 << STATUS_BITS) - 1));
    char message[RSV_MESSAGE_BYTES];
    snprintf(message, sizeof message, "%s", reason ? reason : rsv_last_error());
    team->parted = true;
    team->table->copy(team, failed, message, sizeof message);
    message[sizeof message - 1] = '\0';
    if (failed == 0)
        rsv_fail(failure, "%s", message);
    else
        rsv_fail(failure, "process %u of %u: %s", failed, team->size, message);
    team->failure = failure;
    snprintf(team->reason, sizeof team->reason, "%s", rsv_last_error());
    return failure;
}

/// The items of one owner, in their blocks, next to each other; or back from there.
typedef struct packing {
    char *items, *packed;
    size_t item_bytes, count, block;
} packing;

/// Moves the blocks of `owner`, which start at item `at` when packed. @return where the next owner's start
static size_t move_blocks(const packing *p, rsv_team_place owner, size_t at, bool unpack)
{
    size_t stride = (size_t)owner.size * p->block;
    for (size_t first = (size_t)owner.rank * p->block; first < p->count; first += stride) {
        size_t left = p->count - first, length = left < p->block ? left : p->block;
        char *there = p->packed + at * p->item_bytes, *here = p->items + first * p->item_bytes;
        memcpy(unpack ? here : there, unpack ? there : here, length * p->item_bytes);
        at += length;
    }
    return at;
}

void rsv_team_merge(
    rsv_context *context, void *array, size_t item_bytes, size_t count, size_t block)
{
    rsv_team_place place = rsv_team_place_of(context);
    if (place.size == 1) return;
    size_t *begin = rsv_alloc(context, (size_t)place.size + 1, sizeof *begin);
    packing p = { array, rsv_reserve(context, count, item_bytes), item_bytes, count, block };
    bool complete = begin && p.packed;
    if (rsv_team_meet(context, complete ? RSV_OK : RSV_ERROR_MEMORY) == RSV_OK && complete) {
        for (uint32_t rank = 0; rank < place.size; rank++)
            begin[rank + 1] =
                move_blocks(&p, (rsv_team_place){ rank, place.size }, begin[rank], false);
        rsv_team *team = rsv_team_of(context);
        team->table->share(team, p.packed, item_bytes, begin); // all have just met
        for (uint32_t rank = 0; rank < place.size; rank++)
            move_blocks(&p, (rsv_team_place){ rank, place.size }, begin[rank], true);
    }
    rsv_free(context, begin);
    rsv_free(context, p.packed);
}

void rsv_team_share(rsv_context *context, void *array, size_t item_bytes, const size_t *begin)
{
    rsv_team *team = rsv_team_of(context);
    if (team && rsv_team_meet(context, RSV_OK) == RSV_OK)
        team->table->share(team, array, item_bytes, begin);
}

void rsv_team_sum(rsv_context *context, int64_t *value, size_t count)
{
    rsv_team *team = rsv_team_of(context);
    if (team && rsv_team_meet(context, RSV_OK) == RSV_OK) team->table->sum(team, value, count);
}

void rsv_team_copy(rsv_context *context, uint32_t from, void *data, size_t bytes)
{
    rsv_team *team = rsv_team_of(context);
    if (team && rsv_team_meet(context, RSV_OK) == RSV_OK)
        team->table->copy(team, from, data, bytes);
}

uint64_t rsv_team_total(rsv_context *context, uint64_t value)
{
    int64_t sum = (int64_t)value;
    rsv_team_sum(context, &sum, 1);
    return (uint64_t)sum;
}

double rsv_team_largest(rsv_context *context, double value)
{
    rsv_team *team = rsv_team_of(context);
    if (!team || rsv_team_meet(context, RSV_OK) != RSV_OK) return value;
    return (double)team->table->largest(team, (int64_t)(value * 1e6)) * 1e-6;
}

double rsv_team_path(rsv_context *context)
{
    rsv_team *team = rsv_team_of(context);
    if (!team) return rsv_thread_seconds();
    rsv_team_meet(context, RSV_OK);
    return team->path;
}

rsv_status rsv_team_compare(rsv_context *context, const char *what, const char *text)
{
    char first[256];
    rsv_status status = RSV_OK;
    snprintf(first, sizeof first, "%s", text);
    rsv_team_copy(context, 0, first, sizeof first);
    if (strncmp(first, text, sizeof first - 1) != 0)
        status = rsv_fail(RSV_ERROR_ARGUMENT,
            "its %s differs from that of process 0 (%.24s instead of %.24s); all processes need the same",
            what, text, first);
    return rsv_team_meet(context, status);
}
