/// Dividing work among the processes of a context's team. In a single process, all of this does nothing.
///
/// There are two ways to divide work: blocks of items, assigned round-robin (rsv_team_owns, rsv_team_merge), for loops
/// whose items cost about the same; and segments of a curve (operator/division.h), for the rows of G.
///
/// If one process fails, the contexts of all processes are notified: rsv_cancelled() becomes true, and rsv_progress()
/// returns the failure. Loops between collective calls therefore need no code for teams.
#ifndef RSV_CORE_TEAM_H
#define RSV_CORE_TEAM_H

#include "core.h"
#include "resolvent/team.h"

#define RSV_TEAM_BLOCK 64 ///< nodes that stay together

/// The only exported symbol of the plug-in, and the interface version that it must report.
#define RSV_TEAM_OPEN "rsv_mpi_join"
typedef rsv_status (*rsv_team_open)(const char *version, rsv_team **team, char *message);

/// Which process this is, of how many.
typedef struct rsv_team_place {
    uint32_t rank, size;
} rsv_team_place;

/// The context's team, possibly of a single process; NULL = none.
rsv_team *rsv_context_team(const rsv_context *context);
/// The team, if it has several processes; otherwise NULL.
rsv_team *rsv_team_of(const rsv_context *context);
rsv_team_place rsv_team_place_of(const rsv_context *context);

/// Whether this process computes item `index`. @param block items per block
static inline bool rsv_team_owns(rsv_team_place place, size_t index, size_t block)
{
    return index / block % place.size == place.rank;
}

/// How many of `count` items this process computes, where processes take turns item by item.
static inline size_t rsv_team_turns(rsv_team_place place, size_t count)
{
    return count > place.rank ? (count - place.rank + place.size - 1) / place.size : 0;
}

/// Hands all items of `array` to all, each from its owner.
void rsv_team_merge(
    rsv_context *context, void *array, size_t item_bytes, size_t count, size_t block);

/// The collective calls of the team.
void rsv_team_share(rsv_context *context, void *array, size_t item_bytes, const size_t *begin);
void rsv_team_sum(rsv_context *context, int64_t *value, size_t count);
void rsv_team_copy(rsv_context *context, uint32_t from, void *data, size_t bytes);
/// One count, over all processes.
uint64_t rsv_team_total(rsv_context *context, uint64_t value);

/// The largest value of any process, to a millionth. Decisions based on time and memory use it, so that all processes
/// agree.
double rsv_team_largest(rsv_context *context, double value);

/// Processor seconds along the critical path so far; only differences mean something. Waiting for others is not work.
double rsv_team_path(rsv_context *context);

/// Notifies all processes at once of a failure inside a loop, instead of at the next synchronisation. This process
/// stops immediately, the others at their next progress report. Any thread may call it.
void rsv_team_alarm(rsv_context *context);

/// The failure of one is the failure of all.
rsv_status rsv_team_meet(rsv_context *context, rsv_status status);

/// Fails unless all processes have the same text. @param what for the message, such as "scene" @param text its first 24
/// characters appear in the message
rsv_status rsv_team_compare(rsv_context *context, const char *what, const char *text);

#endif
