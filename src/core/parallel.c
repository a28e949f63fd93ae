#include "parallel.h"

#include <stdio.h>

/// Data shared by the workers of a loop.
typedef struct team_job {
    void (*body)(void *job, int worker);
    void *job;
    size_t workers;
    atomic_size_t started;
    atomic_flag noted;  ///< set by the first worker that failed
    char message[1024]; ///< its error
} team_job;

static _Thread_local bool inside; // in the body of a loop: nested loops run on this thread

static void run_worker(team_job *team, int worker)
{
    unsigned before = rsv_error_count();
    bool was_inside = inside;
    inside = true;
    team->body(team->job, worker);
    inside = was_inside;
    if (rsv_error_count() != before && !atomic_flag_test_and_set(&team->noted))
        snprintf(team->message, sizeof team->message, "%s", rsv_last_error());
}

/// Workers are numbered as they start, not by their tasks: if these run one after the other, backwards, it is the first
/// to run that does the work, and so reports progress as worker 0.
static void run_task(void *data, size_t index)
{
    team_job *team = data;
    (void)index;
    size_t worker = atomic_fetch_add(&team->started, 1);
    if (worker < team->workers)
        run_worker(team, (int)worker); // a task run twice has no work of its own
}

static void run_team(const rsv_context *context, team_job *team)
{
    const rsv_context_desc *desc = rsv_context_settings(context);
    if (desc->parallel) {
        desc->parallel(desc->user, team->workers, run_task, team);
        if (team->started == 0) run_task(team, 0); // one worker is enough for all the work
        return;
    }
    int workers = (int)team->workers;
#pragma omp parallel for num_threads(workers) schedule(static, 1)
    for (int worker = 0; worker < workers; worker++)
        run_worker(team, worker);
}

void rsv_parallel_workers(
    const rsv_context *context, size_t most, void (*body)(void *job, int worker), void *job)
{
    size_t workers = (size_t)rsv_threads(context);
    if (workers > most) workers = most;
    if (inside) workers = 1;
    if (workers <= 1) {
        if (most) body(job, 0);
        return;
    }
    team_job team = { .body = body, .job = job, .workers = workers, .noted = ATOMIC_FLAG_INIT };
    run_team(context, &team);
    if (team.message[0]) rsv_note_error("%s", team.message); // the calling thread's error now
}

rsv_share rsv_share_of(size_t count, size_t grain)
{
    return (rsv_share){ .count = count, .grain = grain };
}

bool rsv_share_take(rsv_share *share, int worker, rsv_span *span)
{
    size_t begin = atomic_fetch_add_explicit(&share->next, share->grain, memory_order_relaxed);
    if (begin >= share->count) return false;
    size_t end = share->count - begin > share->grain ? begin + share->grain : share->count;
    *span = (rsv_span){ begin, end, worker };
    return true;
}

typedef struct loop_job {
    rsv_share share;
    void (*body)(void *job, rsv_span span);
    void *job;
} loop_job;

static void take_spans(void *data, int worker)
{
    loop_job *loop = data;
    for (rsv_span span; rsv_share_take(&loop->share, worker, &span);)
        loop->body(loop->job, span);
}

void rsv_parallel_for(const rsv_context *context, size_t count, size_t grain,
    void (*body)(void *job, rsv_span span), void *job)
{
    size_t threads = (size_t)rsv_threads(context);
    if (grain == 0) grain = (count + threads - 1) / threads;
    if (grain == 0) return;
    loop_job loop = { rsv_share_of(count, grain), body, job };
    rsv_parallel_workers(context, (count + grain - 1) / grain, take_spans, &loop);
}

void rsv_item_done(
    rsv_context *context, const char *phase, int worker, atomic_size_t *done, size_t count)
{
    size_t now = atomic_fetch_add_explicit(done, 1, memory_order_relaxed) + 1;
    if (worker == 0) rsv_progress(context, phase, (double)now / (double)count);
}

void rsv_atomic_max(_Atomic double *most, double value)
{
    double known = atomic_load_explicit(most, memory_order_relaxed);
    while (value > known)
        if (atomic_compare_exchange_weak_explicit(
                most, &known, value, memory_order_relaxed, memory_order_relaxed))
            return;
}

void rsv_keep_failure(_Atomic rsv_status *result, rsv_status status)
{
    rsv_status none = RSV_OK;
    if (status != RSV_OK) atomic_compare_exchange_strong(result, &none, status);
}
