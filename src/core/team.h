/// Sharing among the processes of a context's team. Alone, all of this does nothing and costs nothing.
///
/// Two ways to divide work: items in blocks that take turns (rsv_team_owns, rsv_team_merge), for loops whose items cost
/// about the same; and parts of a curve (operator/division.h), for the rows of G.
///
/// A failure of any process is noted in the context of all: rsv_cancelled() is true from then on, and rsv_progress()
/// returns what failed. So loops between collective calls need not know of teams.
#ifndef RSV_CORE_TEAM_H
#define RSV_CORE_TEAM_H

#include "core.h"
#include "resolvent/team.h"

#define RSV_TEAM_BLOCK 64 ///< nodes that stay together

/// The plug-in's one symbol, and what it must say of itself.
#define RSV_TEAM_OPEN "rsv_mpi_join"
typedef rsv_status (*rsv_team_open)(const char *version, rsv_team **team, char *message);

/// Which process this is, of how many.
typedef struct rsv_team_place {
    uint32_t rank, size;
} rsv_team_place;

/// The context's team, be it of one process; NULL = it has none.
rsv_team *rsv_context_team(const rsv_context *context);
/// A team of several processes; NULL = alone.
rsv_team *rsv_team_of(const rsv_context *context);
rsv_team_place rsv_team_place_of(const rsv_context *context);

/// Whether it is this process's turn to compute item `index`, one of blocks of so many.
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

/// The largest value of any process, to a millionth: what time and memory are judged by, so that all decide alike.
double rsv_team_largest(rsv_context *context, double value);

/// Processor seconds along the critical path so far; only differences mean something. Waiting for others is not work.
double rsv_team_path(rsv_context *context);

/// What failed, in a loop between meetings, shall not wait for the next one: all are asked to stop, here at once and in
/// the others when they report progress. Any thread may call it.
void rsv_team_alarm(rsv_context *context);

/// The failure of one is the failure of all.
rsv_status rsv_team_meet(rsv_context *context, rsv_status status);

/// Fails unless all processes have the same text. @param what "scene", for the message @param text the first 24 characters
/// stand in the message
rsv_status rsv_team_compare(rsv_context *context, const char *what, const char *text);

#endif
