#include "row_device.h"

#include "../core/parallel.h"
#include "../trace/hierarchy.h"
#include "operator_constants.h"

struct rsv_row_device {
    rsv_context *context;
    const rsv_row_tracer *tracer;
    const rsv_device_rows_table *table;
    rsv_device_rows *rows; ///< NULL = it has failed
    size_t most;
    rsv_row_receiver *receiver; ///< [most]
    rsv_device_ends ends;
    size_t *left_begin; ///< [most + 1] into the rays that are left
};

static rsv_status allocate(rsv_row_device *d)
{
    size_t rays = d->tracer->directions.count, ends = d->most * rays;
    d->receiver = rsv_alloc(d->context, d->most, sizeof *d->receiver);
    d->left_begin = rsv_alloc(d->context, d->most + 1, sizeof *d->left_begin);
    d->ends.column = rsv_reserve(d->context, ends, sizeof *d->ends.column);
    d->ends.left = rsv_reserve(d->context, ends, sizeof *d->ends.left);
    d->ends.hit = rsv_reserve(d->context, ends, sizeof *d->ends.hit);
    bool complete = d->receiver && d->left_begin && d->ends.column && d->ends.left && d->ends.hit;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status bring_rows(rsv_row_device *d, rsv_device *device)
{
    rsv_status status = RSV_OK;
    char message[RSV_DEVICE_MESSAGE_BYTES];
    const rsv_row_tracer *t = d->tracer;
    rsv_device_rows_desc desc = { .scene = t->scene->view,
        .elements = t->elements,
        .target = t->target,
        .directions = &t->directions,
        .seed = t->seed,
        .most = (uint32_t)d->most,
        .sky = t->scene->view->environment != NULL };
    RSV_TRY(rsv_tracer_hierarchy(t->scene->tracer, &desc.bvh));
    status = d->table->create(device, &desc, &d->rows, message);
    if (status != RSV_OK) status = rsv_device_failed(d->context, status, message);
cleanup:
    return status;
}

/// Whole blocks.
static size_t rows_at_a_time(const rsv_row_tracer *tracer, size_t rows)
{
    size_t most = RAYS_AT_A_TIME / tracer->directions.count;
    if (most > rows) most = rows;
    return (most + RSV_ROW_BLOCK - 1) / RSV_ROW_BLOCK * RSV_ROW_BLOCK;
}

rsv_status rsv_row_device_create(const rsv_row_tracer *tracer, size_t rows, rsv_row_device **made)
{
    rsv_status status = RSV_OK;
    rsv_context *context = tracer->elements->context;
    rsv_device *device = tracer->scene->view->fog ? NULL : rsv_context_device(context);
    *made = NULL;
    if (!device || !device->desc.rows) return RSV_OK;
    rsv_row_device *d = rsv_alloc(context, 1, sizeof *d);
    if (!d) return RSV_ERROR_MEMORY;
    d->context = context;
    d->tracer = tracer;
    d->table = device->table->rows;
    d->most = rows_at_a_time(tracer, rows);
    RSV_TRY(allocate(d));
    RSV_TRY(bring_rows(d, device));
    if (d->rows) {
        *made = d;
        d = NULL;
    }
cleanup:
    rsv_row_device_destroy(d);
    return status;
}

void rsv_row_device_destroy(rsv_row_device *d)
{
    if (!d) return;
    if (d->rows) d->table->destroy(d->rows);
    rsv_free(d->context, d->receiver);
    rsv_free(d->context, d->left_begin);
    rsv_free(d->context, d->ends.column);
    rsv_free(d->context, d->ends.left);
    rsv_free(d->context, d->ends.hit);
    rsv_free(d->context, d);
}

size_t rsv_row_device_most(const rsv_row_device *d) { return d->most; }

/// Sorts the rays that are left, which come in order, by row.
static void share_left(rsv_row_device *d, size_t count)
{
    uint32_t rays = d->tracer->directions.count;
    size_t n = 0;
    for (size_t row = 0; row < count; row++) {
        d->left_begin[row] = n;
        for (; n < d->ends.left_count && d->ends.left[n] / rays == row; n++)
            d->ends.left[n] %= rays;
    }
    d->left_begin[count] = n;
}

typedef struct receive_job {
    const rsv_row_device *device;
    const uint32_t *node;
} receive_job;

static void receive_rows(void *data, rsv_span span)
{
    const receive_job *job = data;
    for (size_t k = span.begin; k < span.end; k++)
        rsv_row_receive(job->device->tracer, job->node[k], &job->device->receiver[k]);
}

rsv_status rsv_row_device_trace(rsv_row_device *d, const uint32_t *node, size_t count, bool *done)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    *done = false;
    if (!d || !d->rows) return RSV_OK;
    receive_job job = { d, node };
    rsv_parallel_for(d->context, count, 16, receive_rows, &job);
    rsv_status status = d->table->trace(d->rows, d->receiver, (uint32_t)count, &d->ends, message);
    if (status != RSV_OK) {
        d->table->destroy(d->rows);
        d->rows = NULL;
        return rsv_device_failed(d->context, status, message);
    }
    share_left(d, count);
    *done = true;
    return RSV_OK;
}

void rsv_row_device_finish(const rsv_row_device *d, size_t index, rsv_row_scratch *scratch)
{
    size_t first = d->left_begin[index], rays = d->tracer->directions.count;
    const rsv_row_ends ends = { d->ends.column + index * rays, d->ends.left + first,
        d->ends.hit + first, d->left_begin[index + 1] - first };
    rsv_row_finish(d->tracer, &d->receiver[index], &ends, scratch);
}
