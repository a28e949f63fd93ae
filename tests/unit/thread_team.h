/// A team whose processes are threads of the test. It tests sharing and the handling of failures where there is no MPI.
#ifndef RSV_TEST_THREAD_TEAM_H
#define RSV_TEST_THREAD_TEAM_H

#include "core/team.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define TEAM_MOST 16

/// What the members see of each other in one call.
typedef struct team_room {
    uint32_t size;
    pthread_barrier_t barrier;
    void *array[TEAM_MOST];
    int64_t value[TEAM_MOST];
    atomic_bool alarmed;
    size_t shared_bytes; ///< handed on by rsv_team_share, all together
} team_room;

typedef struct thread_member {
    rsv_team base;
    team_room *room;
    void (*body)(rsv_team *team, void *user);
    void *user;
} thread_member;

static inline team_room *room_of(rsv_team *team) { return ((thread_member *)team)->room; }

static inline void thread_share(rsv_team *team, void *array, size_t item_bytes, const size_t *begin)
{
    team_room *room = room_of(team);
    room->array[team->rank] = array;
    if (team->rank == 0) room->shared_bytes += begin[team->size] * item_bytes;
    pthread_barrier_wait(&room->barrier);
    for (uint32_t r = 0; r < team->size; r++)
        if (r != team->rank)
            memcpy((char *)array + begin[r] * item_bytes,
                (char *)room->array[r] + begin[r] * item_bytes,
                (begin[r + 1] - begin[r]) * item_bytes);
    pthread_barrier_wait(&room->barrier);
}

static inline void thread_sum(rsv_team *team, int64_t *value, size_t count)
{
    team_room *room = room_of(team);
    int64_t *sum = calloc(count + 1, sizeof *sum);
    room->array[team->rank] = value;
    pthread_barrier_wait(&room->barrier);
    for (uint32_t r = 0; r < team->size; r++)
        for (size_t k = 0; k < count; k++)
            sum[k] += ((int64_t *)room->array[r])[k];
    pthread_barrier_wait(&room->barrier);
    memcpy(value, sum, count * sizeof *value);
    free(sum);
}

static inline int64_t thread_largest(rsv_team *team, int64_t value)
{
    team_room *room = room_of(team);
    room->value[team->rank] = value;
    pthread_barrier_wait(&room->barrier);
    for (uint32_t r = 0; r < team->size; r++)
        if (room->value[r] > value) value = room->value[r];
    pthread_barrier_wait(&room->barrier);
    return value;
}

static inline void thread_copy(rsv_team *team, uint32_t from, void *data, size_t bytes)
{
    team_room *room = room_of(team);
    room->array[team->rank] = data;
    pthread_barrier_wait(&room->barrier);
    if (team->rank != from) memcpy(data, room->array[from], bytes);
    pthread_barrier_wait(&room->barrier);
}

static inline double thread_progress(rsv_team *team, const char *phase, double fraction)
{
    (void)team, (void)phase;
    return fraction;
}

static inline bool thread_alarm(rsv_team *team, bool give)
{
    team_room *room = room_of(team);
    if (give) atomic_store(&room->alarmed, true);
    return atomic_load(&room->alarmed);
}

static inline void *thread_run(void *argument)
{
    thread_member *member = argument;
    member->body(&member->base, member->user);
    return NULL;
}

/// Runs `body` in `size` threads, each a process of one team.
/// @return bytes that rsv_team_share handed on
static inline size_t run_team(uint32_t size, void (*body)(rsv_team *team, void *user), void *user)
{
    static const rsv_team_table table = { .share = thread_share,
        .sum = thread_sum,
        .largest = thread_largest,
        .copy = thread_copy,
        .progress = thread_progress,
        .alarm = thread_alarm };
    team_room room = { .size = size };
    thread_member member[TEAM_MOST];
    pthread_t thread[TEAM_MOST];
    pthread_barrier_init(&room.barrier, NULL, size);
    for (uint32_t r = 0; r < size; r++) {
        member[r] =
            (thread_member){ { .table = &table, .rank = r, .size = size }, &room, body, user };
        pthread_create(&thread[r], NULL, thread_run, &member[r]);
    }
    for (uint32_t r = 0; r < size; r++)
        pthread_join(thread[r], NULL);
    pthread_barrier_destroy(&room.barrier);
    return room.shared_bytes;
}

#endif
