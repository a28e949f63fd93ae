/// How evenly rows of G can be divided, and how much the parts would communicate, computed in a single process.
#include "../core/parallel.h"
#include "../operator/row_tracer.h"
#include "light_internal.h"
#include "resolvent/measure.h"

#include <string.h>

#define ROUNDS 2 ///< in which rows are timed, so that a hiccup of the machine does not count

static void time_block(const rsv_row_tracer *tracer, const rsv_division *d, size_t first,
    rsv_row_scratch *scratch, float *seconds)
{
    for (size_t k = first; k < first + RSV_ROW_BLOCK && k < d->node_count; k++) {
        if (!tracer->valid_points[d->order[k]]) continue;
        double start = rsv_thread_seconds();
        rsv_row_trace(tracer, d->order[k], scratch);
        float taken = (float)(rsv_thread_seconds() - start);
        if (seconds[k] <= 0 || taken < seconds[k]) seconds[k] = taken;
    }
}

/// Data shared by workers that time rows.
typedef struct time_job {
    const rsv_row_tracer *tracer;
    const rsv_division *division;
    float *seconds;   ///< [node_count] along the curve
    rsv_share blocks; ///< of rows
    _Atomic rsv_status status;
} time_job;

static void time_blocks(void *data, int worker)
{
    time_job *job = data;
    const rsv_division *d = job->division;
    size_t blocks = job->blocks.count, step = rsv_division_step(blocks);
    rsv_row_scratch scratch = { 0 };
    rsv_status status = rsv_row_scratch_create(d->context, job->tracer->directions.count, &scratch);
    rsv_keep_failure(&job->status, status);
    for (rsv_span s; status == RSV_OK && rsv_share_take(&job->blocks, worker, &s);) {
        if (rsv_cancelled(d->context)) break;
        size_t first = s.begin * step % blocks * RSV_ROW_BLOCK;
        time_block(job->tracer, d, first, &scratch, job->seconds);
    }
    rsv_row_scratch_destroy(d->context, &scratch);
}

/// Traces all rows again and records the time of each, along the curve; keeps earlier times that were shorter.
static rsv_status time_rows(
    const rsv_row_tracer *tracer, const rsv_division *division, float *seconds)
{
    time_job job = { .tracer = tracer,
        .division = division,
        .seconds = seconds,
        .blocks = rsv_share_of(division->node_count / RSV_ROW_BLOCK + 1, 1) };
    rsv_parallel_workers(division->context, SIZE_MAX, time_blocks, &job);
    return job.status == RSV_OK ? rsv_progress(division->context, "divide", 1) : job.status;
}

/// Values that the rows of one part need from others.
typedef struct demand {
    const rsv_elements *elements;
    const uint32_t *owner; ///< [node_count] part of each node
    uint32_t *seen;        ///< [node_count] the last part that met a node, plus one
    uint8_t *sends;        ///< [part_count]
    uint32_t part;
    size_t received, senders;
} demand;

/// Values of nodes that hang follow from those of their parents.
static void ask_for(demand *d, uint32_t node)
{
    if (d->seen[node] == d->part + 1) return;
    d->seen[node] = d->part + 1;
    uint32_t hangs = d->elements->node_hanging[node];
    if (hangs != RSV_NONE) {
        const rsv_hanging *h = &d->elements->hanging[hangs];
        for (int p = 0; p < RSV_PARENTS; p++)
            if (h->weight[p] > 0) ask_for(d, h->parent[p]);
        return;
    }
    uint32_t owner = d->owner[node];
    if (owner == d->part) return;
    d->received += 3;
    d->senders += !d->sends[owner];
    d->sends[owner] = 1;
}

static void count_needed(
    const rsv_transport *t, const rsv_division *division, demand *d, rsv_division_cost *cost)
{
    d->received = d->senders = 0;
    memset(d->sends, 0, division->part_count);
    for (size_t k = division->begin[d->part]; k < division->begin[d->part + 1]; k++) {
        rsv_transport_row row = rsv_transport_row_at(t, division->order[k]);
        for (size_t i = 0; i < row.count; i++)
            ask_for(d, row.column[i]);
        for (size_t i = 0; i < row.tinted_count; i++)
            ask_for(d, row.tinted_column[i]);
    }
    cost->received_mean += (double)d->received / division->part_count;
    cost->received_most = fmax(cost->received_most, (double)d->received);
    cost->senders_mean += (double)d->senders / division->part_count;
}

static rsv_status measure_cut(
    const rsv_light *s, const rsv_division *d, const float *seconds, rsv_division_cost *cost)
{
    rsv_status status = RSV_OK;
    uint32_t *owner = rsv_alloc(d->context, d->node_count, sizeof *owner);
    uint32_t *seen = rsv_alloc(d->context, d->node_count, sizeof *seen);
    uint8_t *sends = rsv_alloc(d->context, d->part_count, 1);
    double total = 0, most = 0;
    RSV_TRY(owner && seen && sends ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t part = 0; part < d->part_count; part++)
        for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
            owner[d->order[k]] = part;
    demand needed = { s->elements, owner, seen, sends, 0, 0, 0 };
    for (uint32_t part = 0; part < d->part_count; part++) {
        double sum = 0;
        for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
            sum += (double)seconds[k];
        total += sum;
        most = fmax(most, sum);
        needed.part = part;
        count_needed(s->view.transport, d, &needed, cost);
    }
    cost->imbalance = total > 0 ? most * d->part_count / total : 1;
cleanup:
    rsv_free(d->context, owner);
    rsv_free(d->context, seen);
    rsv_free(d->context, sends);
    return status;
}

rsv_status rsv_measure_division(
    const rsv_light *s, const uint32_t *parts, size_t count, rsv_division_cost *cost)
{
    rsv_status status;
    rsv_division *division = NULL;
    rsv_row_tracer tracer = { &s->scene, s->sources->lights, s->elements, s->view.valid_points,
        .seed = s->desc.seed };
    float *seconds = rsv_alloc(s->context, s->elements->node_count, sizeof *seconds);
    RSV_TRY(seconds ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_row_tracer_begin(&tracer, s->desc.rays_per_element));
    RSV_TRY(rsv_row_costs(&tracer, &division));
    for (int round = 0; round < ROUNDS; round++)
        RSV_TRY(time_rows(&tracer, division, seconds));
    for (size_t k = 0; k < count; k++) {
        cost[k] = (rsv_division_cost){ .parts = parts[k] };
        RSV_TRY(rsv_division_cut(division, 0, parts[k]));
        RSV_TRY(measure_cut(s, division, seconds, &cost[k]));
    }
cleanup:
    rsv_row_tracer_end(&tracer);
    rsv_division_destroy(division);
    rsv_free(s->context, seconds);
    return status;
}
