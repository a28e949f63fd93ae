/// Cost of rows of G, measured with a few rays of a few rows.
#include "../core/parallel.h"
#include "../core/team.h"
#include "../update/update.h"
#include "operator_constants.h"
#include "row_tracer.h"

/// Nodes with a row, along the curve. @return how many
static size_t list_rows(const rsv_row_tracer *tracer, const rsv_division *d, uint32_t *along)
{
    size_t rows = 0;
    for (size_t k = 0; k < d->node_count; k++)
        if (tracer->valid_points[d->order[k]]) along[rows++] = d->order[k];
    return rows;
}

static int64_t time_row(const rsv_row_tracer *tracer, uint32_t node, rsv_row_scratch *scratch)
{
    double start = rsv_thread_seconds();
    rsv_row_trace(tracer, node, scratch);
    return (int64_t)(1e9 * (rsv_thread_seconds() - start));
}

/// Times rows again that took much longer than the previous one, because the machine may have been busy.
static void probe_turn(const rsv_row_tracer *tracer, const uint32_t *along, size_t rows,
    size_t first, rsv_row_scratch *scratch, int64_t *nanoseconds)
{
    size_t stretches = (rows + STRETCH - 1) / STRETCH;
    int64_t before = INT64_MAX / DOUBTFUL;
    for (size_t k = first; k < first + COST_TURN && k < stretches; k++) {
        size_t middle = k * STRETCH + STRETCH / 2;
        uint32_t node = along[middle < rows ? middle : rows - 1];
        int64_t time = time_row(tracer, node, scratch);
        if (time > DOUBTFUL * before) {
            int64_t again = time_row(tracer, node, scratch);
            if (again < time) time = again;
        }
        nanoseconds[k] = before = time;
    }
}

/// Data shared by the workers that time rows.
typedef struct cost_job {
    const rsv_row_tracer *tracer;
    const uint32_t *along; ///< [rows]
    size_t rows, turns;
    rsv_team_place place;
    int64_t *nanoseconds; ///< out, per stretch
    rsv_share share;      ///< of this process's turns
    _Atomic rsv_status status;
} cost_job;

static void take_turns(void *data, int worker)
{
    cost_job *job = data;
    rsv_context *context = job->tracer->elements->context;
    size_t step = rsv_division_step(job->turns);
    rsv_row_scratch scratch = { 0 };
    rsv_status status = rsv_row_scratch_create(context, COST_RAYS, &scratch);
    rsv_keep_failure(&job->status, status);
    for (rsv_span s; status == RSV_OK && rsv_share_take(&job->share, worker, &s);) {
        if (rsv_cancelled(context)) break;
        size_t turn = job->place.rank + s.begin * job->place.size;
        probe_turn(job->tracer, job->along, job->rows, turn * step % job->turns * COST_TURN,
            &scratch, job->nanoseconds);
    }
    rsv_row_scratch_destroy(context, &scratch);
}

static rsv_status measure(
    const rsv_row_tracer *tracer, const uint32_t *along, size_t rows, int64_t *nanoseconds)
{
    rsv_context *context = tracer->elements->context;
    rsv_team_place place = rsv_team_place_of(context);
    size_t turns = rows / (STRETCH * COST_TURN) + 1;
    size_t own = (turns + place.size - 1 - place.rank) / place.size;
    cost_job job = { .tracer = tracer,
        .along = along,
        .rows = rows,
        .turns = turns,
        .place = place,
        .nanoseconds = nanoseconds,
        .share = rsv_share_of(own, 1) };
    rsv_parallel_workers(context, SIZE_MAX, take_turns, &job);
    return rsv_team_meet(context, job.status);
}

/// Whether each process keeps its rows for a later version of the scene where no other finds them.
static bool keeps_its_own(const rsv_row_tracer *tracer)
{
    const rsv_store *store = tracer->scene->update ? tracer->scene->update->store : NULL;
    return store && !store->shared;
}

rsv_status rsv_row_costs(const rsv_row_tracer *tracer, rsv_division **division)
{
    rsv_context *context = tracer->elements->context;
    rsv_status status;
    size_t nodes = tracer->elements->node_count, stretches = nodes / STRETCH + 1;
    rsv_row_tracer probe = *tracer;
    probe.target = NULL;
    probe.directions = (rsv_directions){ 0 };
    uint32_t *along = rsv_alloc(context, nodes, sizeof *along);
    int64_t *nanoseconds = rsv_alloc(context, stretches, sizeof *nanoseconds);
    RSV_TRY(along && nanoseconds ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_row_tracer_begin(&probe, COST_RAYS));
    RSV_TRY(rsv_division_create(tracer->elements, division));
    size_t rows = list_rows(&probe, *division, along);
    // stored rows must be found again, so the division must not depend on timings
    if (!keeps_its_own(tracer)) RSV_TRY(measure(&probe, along, rows, nanoseconds));
    rsv_team_sum(context, nanoseconds, stretches);
    for (size_t k = 0; k < rows; k++)
        (*division)->cost[along[k]] = f_max((float)nanoseconds[k / STRETCH], 1);
cleanup:
    rsv_row_tracer_end(&probe);
    rsv_free(context, along);
    rsv_free(context, nanoseconds);
    return status;
}
