#include "transport.h"

#include <stdlib.h>

static size_t entries(const rsv_device_transport *t)
{
    return t->system.row_begin[t->system.node_count];
}

static size_t tinted_entries(const rsv_device_transport *t)
{
    return t->system.tinted_begin[t->system.node_count];
}

static size_t parent_count(const rsv_device_transport *t)
{
    return t->system.parents.begin[t->system.node_count];
}

static void lay_out_rows(void *task, rsv_gpu_block *b)
{
    rsv_device_transport *t = task;
    size_t nodes = t->system.node_count;
    rsv_gather_args *g = &t->gather;
    rsv_leave_args *l = &t->leave;
    g->row_begin = rsv_gpu_place(b, nodes + 1, sizeof *g->row_begin);
    g->column = rsv_gpu_place(b, entries(t), sizeof *g->column);
    g->tinted_begin = rsv_gpu_place(b, nodes + 1, sizeof *g->tinted_begin);
    g->tinted_column = rsv_gpu_place(b, tinted_entries(t), sizeof *g->tinted_column);
    g->tinted_weight = rsv_gpu_place(b, tinted_entries(t), sizeof *g->tinted_weight);
    l->parent_begin = rsv_gpu_place(b, nodes + 1, sizeof *l->parent_begin);
    l->parent = rsv_gpu_place(b, parent_count(t), sizeof *l->parent);
    l->parent_weight = rsv_gpu_place(b, parent_count(t), sizeof *l->parent_weight);
    g->scale = t->scale = rsv_gpu_place(b, nodes, sizeof *t->scale);
    l->albedo = t->albedo = rsv_gpu_place(b, nodes, sizeof *t->albedo);
    g->exitance = l->exitance = rsv_gpu_place(b, nodes, sizeof *l->exitance);
    rsv_gpu_diffusion_lay_out(t, b);
    rsv_gpu_solver_lay_out(t, b);
}

static void upload_rows(rsv_device_transport *t)
{
    const rsv_device_system *s = &t->system;
    const rsv_gpu_array array[] = { { t->gather.row_begin, s->row_begin, s->node_count + 1,
                                        sizeof *s->row_begin },
        { t->gather.column, s->column, entries(t), sizeof *s->column },
        { t->gather.tinted_begin, s->tinted_begin, s->node_count + 1, sizeof *s->tinted_begin },
        { t->gather.tinted_column, s->tinted_column, tinted_entries(t), sizeof *s->tinted_column },
        { t->gather.tinted_weight, s->tinted_weight, tinted_entries(t), sizeof *s->tinted_weight },
        { t->leave.parent_begin, s->parents.begin, s->node_count + 1, sizeof *s->parents.begin },
        { t->leave.parent, s->parents.node, parent_count(t), sizeof *s->parents.node },
        { t->leave.parent_weight, s->parents.weight, parent_count(t), sizeof *s->parents.weight } };
    rsv_gpu_upload_all(t->gpu, array, sizeof array / sizeof array[0]);
    rsv_gpu_diffusion_upload(t);
}

static void lay_out_room(void *task, rsv_gpu_block *b)
{
    rsv_device_transport *t = task;
    size_t values = t->system.node_count * t->fields;
    t->field = rsv_gpu_place(b, values, sizeof *t->field);
    t->source = rsv_gpu_place(b, values, sizeof *t->source);
    t->image = rsv_gpu_place(b, values, sizeof *t->image);
}

/// Allocates memory for a number of fields.
static void make_room(rsv_device_transport *t, size_t fields)
{
    if (fields <= t->fields) return;
    t->fields = fields;
    rsv_gpu_release(t->gpu, &t->room);
    rsv_gpu_lay_out(t->gpu, &t->room, lay_out_room, t, "the fields of the operator");
    if (!t->room.base) t->fields = 0; // so that the next call tries again
}

static void destroy(rsv_device_transport *t)
{
    if (!t) return;
    for (int k = 0; k < RSV_GPU_SOLVERS; k++)
        rsv_gpu_forget(t->steps[k]);
    rsv_gpu_release(t->gpu, &t->rows);
    rsv_gpu_release(t->gpu, &t->room);
    free(t);
}

static rsv_status create(rsv_device *device, const rsv_device_system *system,
    rsv_device_transport **transport, char *message)
{
    rsv_device_transport *t = rsv_gpu_new(sizeof *t, message);
    if (!t) return RSV_ERROR_MEMORY;
    t->gpu = (rsv_gpu *)device;
    t->system = *system;
    rsv_gpu_lay_out(t->gpu, &t->rows, lay_out_rows, t, "the operator");
    upload_rows(t);
    rsv_gpu_clear(t->gpu, t->solver.state, sizeof *t->solver.state); // including padding
    make_room(t, 1);
    rsv_status status = rsv_gpu_wait(t->gpu, message);
    if (status == RSV_OK)
        *transport = t;
    else
        destroy(t);
    return status;
}

// ---- products ------------------------------------------------------------------------------------

void rsv_gpu_transport_refresh(rsv_device_transport *t)
{
    size_t nodes = t->system.node_count;
    rsv_gpu_upload(t->gpu, t->scale, t->system.scale, nodes * sizeof *t->scale);
    rsv_gpu_upload(t->gpu, t->albedo, t->system.albedo, nodes * sizeof *t->albedo);
}

static void begin(rsv_device_transport *t, size_t fields, const rsv_rgb *field)
{
    make_room(t, fields);
    rsv_gpu_transport_refresh(t);
    rsv_gpu_upload(t->gpu, t->field, field, t->system.node_count * fields * sizeof *field);
}

static rsv_status finish(rsv_device_transport *t, size_t fields, rsv_rgb *image, char *message)
{
    rsv_gpu_download(t->gpu, image, t->image, t->system.node_count * fields * sizeof *image);
    return rsv_gpu_wait(t->gpu, message);
}

/// Queues exitance = K field, whose value of node n is at n x fields.
static void scatter(rsv_device_transport *t, const rsv_rgb *field, size_t fields)
{
    rsv_leave_args leave = t->leave;
    leave.field = field;
    leave.fields = (uint32_t)fields;
    if (t->system.diffusion) {
        rsv_gpu_diffuse(t, &leave);
        leave.field = t->diffuse.diffused;
        leave.fields = 1;
    }
    rsv_launch_leave(t->gpu, &leave, t->system.node_count);
}

/// Field `f` of `fields`, from t->field to t->image.
static void queue_product(
    rsv_device_transport *t, size_t fields, size_t f, rsv_gather_launch launch)
{
    rsv_gather_args gather = t->gather;
    gather.fields = (uint32_t)fields;
    gather.field = t->field + f;
    gather.source = t->source + f;
    gather.image = t->image + f;
    scatter(t, gather.field, fields);
    launch(t->gpu, &gather, t->system.node_count);
}

void rsv_gpu_product(
    rsv_device_transport *t, const rsv_rgb *field, rsv_rgb *image, rsv_gather_launch launch)
{
    rsv_gather_args gather = t->gather;
    gather.fields = 1;
    gather.field = field;
    gather.image = image;
    scatter(t, field, 1);
    launch(t->gpu, &gather, t->system.node_count);
}

static rsv_status apply(
    rsv_device_transport *t, size_t fields, const rsv_rgb *field, rsv_rgb *image, char *message)
{
    begin(t, fields, field);
    for (size_t f = 0; f < fields; f++)
        queue_product(t, fields, f, rsv_launch_gather);
    return finish(t, fields, image, message);
}

static rsv_status residual(rsv_device_transport *t, size_t fields, const rsv_rgb *source,
    const rsv_rgb *field, rsv_rgb *difference, char *message)
{
    begin(t, fields, field);
    rsv_gpu_upload(t->gpu, t->source, source, t->system.node_count * fields * sizeof *source);
    for (size_t f = 0; f < fields; f++)
        queue_product(t, fields, f, rsv_launch_gather_residual);
    return finish(t, fields, difference, message);
}

const rsv_device_transport_table rsv_gpu_transport = { .create = create,
    .destroy = destroy,
    .apply = apply,
    .residual = residual,
    .solves = rsv_gpu_solves,
    .solve = rsv_gpu_solve,
    .measure = rsv_gpu_measure };
