/// Loops over all threads of a context: OpenMP's, or those of an embedding program (rsv_context_desc.parallel). No
/// other code of the library starts threads for loops, so embedding programs control where all of them run.
///
/// The body of a loop is a function of a span of indices. Spans are handed out in ascending order to free workers.
/// Results must not depend on which worker gets which span. A loop inside the body of another loop runs on the calling
/// thread.
#ifndef RSV_CORE_PARALLEL_H
#define RSV_CORE_PARALLEL_H

#include "core.h"

#include <stdatomic.h>

/// A piece of a loop.
typedef struct rsv_span {
    size_t begin, end; ///< indices begin <= i < end
    int worker; ///< 0 <= worker < rsv_threads(); spans processed at the same time have different workers
} rsv_span;

/// Calls `body(job, span)` for spans of at most `grain` indices that cover 0 <= i < count once; returns when all are
/// done.
/// @param grain 0 = even shares, one per worker: for loops whose indices cost the same
void rsv_parallel_for(const rsv_context *context, size_t count, size_t grain,
    void (*body)(void *job, rsv_span span), void *job);

/// A loop with per-worker setup before the first span and cleanup after the last:
///
///     static void work(void *user, int worker) // by rsv_parallel_workers()
///     {
///         ...                                  // set up
///         for (rsv_span s; rsv_share_take(&job->share, worker, &s);)
///             for (size_t i = s.begin; i < s.end; i++) ...
///         ...                                  // tear down
///     }
typedef struct rsv_share {
    size_t count, grain;
    atomic_size_t next;
} rsv_share;

/// @param grain 1 or more
rsv_share rsv_share_of(size_t count, size_t grain);

/// The next span of the loop. False = none is left.
bool rsv_share_take(rsv_share *share, int worker, rsv_span *span);

/// Calls `body(job, worker)` once for each worker, at most `most` of them, and returns when all have returned. Workers
/// may run one after the other: none may wait for another.
void rsv_parallel_workers(
    const rsv_context *context, size_t most, void (*body)(void *job, int worker), void *job);

/// Counts one of a loop's `count` items as done; worker 0 reports it (rsv_progress).
/// @param done 0 at first, shared by the workers
void rsv_item_done(
    rsv_context *context, const char *phase, int worker, atomic_size_t *done, size_t count);

/// Makes `value` the new `*most` if it is larger.
void rsv_atomic_max(_Atomic double *most, double value);

/// Keeps the first failure of a loop's workers. RSV_OK changes nothing.
void rsv_keep_failure(_Atomic rsv_status *result, rsv_status status);

#endif
