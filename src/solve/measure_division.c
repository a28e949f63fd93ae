/// How evenly rows of G can be divided, and what the parts would have to tell each other, without any other process.
#include "../operator/row_tracer.h"
#include "solution.h"

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

/// Traces all rows once more and notes the time of each, along the curve; what was less before stays.
static rsv_status time_rows(
    const rsv_row_tracer *tracer, const rsv_division *division, float *seconds)
{
    rsv_context *context = division->context;
    rsv_status result = RSV_OK;
    size_t blocks = division->node_count / RSV_ROW_BLOCK + 1, step = rsv_division_step(blocks);
#pragma omp parallel num_threads(rsv_threads(context))
    {
        rsv_row_scratch scratch;
        rsv_status status = rsv_row_scratch_create(context, tracer->directions.count, &scratch);
#pragma omp for schedule(dynamic, 1)
        for (size_t block = 0; block < blocks; block++)
            if (status == RSV_OK && !rsv_cancelled(context))
                time_block(
                    tracer, division, block * step % blocks * RSV_ROW_BLOCK, &scratch, seconds);
        rsv_row_scratch_destroy(context, &scratch);
        if (status != RSV_OK) {
#pragma omp critical
            result = status;
        }
    }
    return result == RSV_OK ? rsv_progress(context, "divide", 1) : result;
}

/// Nodes of other parts that the rows of `part` refer to, and how many parts those belong to.
/// @param owner [node_count] part of each node @param seen [node_count] the last part that met a node, plus one
static void count_needed(const rsv_transport *t, const rsv_division *d, uint32_t part,
    const uint32_t *owner, uint32_t *seen, uint8_t *sends, rsv_division_cost *cost)
{
    size_t received = 0, senders = 0;
    memset(sends, 0, d->part_count);
    for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
        for (size_t i = t->row_begin[d->order[k]]; i < t->row_begin[d->order[k] + 1]; i++) {
            uint32_t node = t->column[i];
            if (owner[node] == part || seen[node] == part + 1) continue;
            seen[node] = part + 1;
            received += 3;
            senders += !sends[owner[node]];
            sends[owner[node]] = 1;
        }
    cost->received_mean += (double)received / d->part_count;
    cost->received_most = fmax(cost->received_most, (double)received);
    cost->senders_mean += (double)senders / d->part_count;
}

static rsv_status measure_cut(
    const rsv_transport *t, const rsv_division *d, const float *seconds, rsv_division_cost *cost)
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
    for (uint32_t part = 0; part < d->part_count; part++) {
        double sum = 0;
        for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
            sum += (double)seconds[k];
        total += sum;
        most = fmax(most, sum);
        count_needed(t, d, part, owner, seen, sends, cost);
    }
    cost->imbalance = total > 0 ? most * d->part_count / total : 1;
cleanup:
    rsv_free(d->context, owner);
    rsv_free(d->context, seen);
    rsv_free(d->context, sends);
    return status;
}

rsv_status rsv_measure_division(
    const rsv_solution *s, const uint32_t *parts, size_t count, rsv_division_cost *cost)
{
    rsv_status status;
    rsv_division *division = NULL;
    rsv_row_tracer tracer = { &s->scene, s->lights, s->elements, s->valid_points,
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
        RSV_TRY(measure_cut(s->transport, division, seconds, &cost[k]));
    }
cleanup:
    rsv_row_tracer_end(&tracer);
    rsv_division_destroy(division);
    rsv_free(s->context, seconds);
    return status;
}
