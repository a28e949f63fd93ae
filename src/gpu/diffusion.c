#include "transport.h"

static size_t source_count(const rsv_diffusion_rows *d) { return d->mean_begin[d->mean_count]; }

static size_t entries(const rsv_diffusion_rows *d) { return d->row_begin[d->row_count]; }

void rsv_gpu_diffusion_lay_out(rsv_device_transport *t, rsv_gpu_block *b)
{
    const rsv_diffusion_rows *d = t->system.diffusion;
    rsv_diffuse_args *a = &t->diffuse;
    size_t nodes = t->system.node_count;
    if (!d) return;
    a->entered = rsv_gpu_place(b, nodes + d->mean_count, sizeof *a->entered);
    a->diffused = rsv_gpu_place(b, nodes, sizeof *a->diffused);
    a->mean = rsv_gpu_place(b, d->mean_count, sizeof *a->mean);
    a->mean_begin = rsv_gpu_place(b, d->mean_count + 1, sizeof *a->mean_begin);
    a->source = rsv_gpu_place(b, source_count(d), sizeof *a->source);
    a->share = rsv_gpu_place(b, source_count(d), sizeof *a->share);
    a->node = rsv_gpu_place(b, d->row_count, sizeof *a->node);
    a->row_begin = rsv_gpu_place(b, d->row_count + 1, sizeof *a->row_begin);
    a->column = rsv_gpu_place(b, entries(d), sizeof *a->column);
    a->weight = rsv_gpu_place(b, entries(d), sizeof *a->weight);
}

void rsv_gpu_diffusion_upload(rsv_device_transport *t)
{
    const rsv_diffusion_rows *d = t->system.diffusion;
    const rsv_diffuse_args *a = &t->diffuse;
    if (!d) return;
    const rsv_gpu_array array[] = { { a->mean, d->mean, d->mean_count, sizeof *d->mean },
        { a->mean_begin, d->mean_begin, d->mean_count + 1, sizeof *d->mean_begin },
        { a->source, d->source, source_count(d), sizeof *d->source },
        { a->share, d->share, source_count(d), sizeof *d->share },
        { a->node, d->node, d->row_count, sizeof *d->node },
        { a->row_begin, d->row_begin, d->row_count + 1, sizeof *d->row_begin },
        { a->column, d->column, entries(d), sizeof *d->column },
        { a->weight, d->weight, entries(d), sizeof *d->weight } };
    rsv_gpu_upload_all(t->gpu, array, sizeof array / sizeof array[0]);
}

void rsv_gpu_diffuse(rsv_device_transport *t, const rsv_leave_args *entering)
{
    const rsv_diffusion_rows *d = t->system.diffusion;
    rsv_diffuse_args a = t->diffuse;
    a.leave = *entering;
    rsv_launch_enter(t->gpu, &a, t->system.node_count);
    for (size_t level = 0; level < d->level_count; level++) {
        a.first_mean = d->level_begin[level];
        rsv_launch_mean(t->gpu, &a, d->level_begin[level + 1] - a.first_mean);
    }
    rsv_launch_diffuse(t->gpu, &a, d->row_count);
}

size_t rsv_gpu_diffusion_bytes(const rsv_device_transport *t)
{
    const rsv_diffusion_rows *d = t->system.diffusion;
    if (!d) return 0;
    return 2 * t->system.node_count * sizeof(rsv_rgb) + d->row_count * sizeof *d->row_begin +
           entries(d) * (sizeof *d->column + sizeof *d->weight) +
           source_count(d) * (sizeof *d->source + sizeof *d->share);
}
