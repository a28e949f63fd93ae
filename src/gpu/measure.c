/// How fast the device is: by its own clock, all of it in one run.
#include "transport.h"

#include <stdio.h>

/// Bytes of a copy that no cache holds.
static size_t copy_bytes(const rsv_gpu *gpu)
{
    size_t cache = gpu->device.info.cache_bytes;
    return cache ? 8 * cache : (size_t)1 << 20;
}

/// Bytes read and written per second by copies of a large array.
static void measure_copy(rsv_gpu *gpu, uint32_t repetitions, double *rate)
{
    rsv_gpu_block block = { 0 };
    size_t bytes = copy_bytes(gpu);
    rsv_gpu_place(&block, 2, bytes);
    rsv_gpu_reserve(gpu, &block, "measuring the memory");
    rsv_gpu_clear(gpu, block.base, 2 * bytes);
    for (uint32_t k = 0; k < repetitions; k++) {
        rsv_gpu_mark(gpu, 0);
        rsv_gpu_copy(gpu, block.base, block.base + bytes, bytes);
        rsv_gpu_mark(gpu, 1);
        rate[k] = 2 * (double)bytes / rsv_gpu_marked_seconds(gpu);
    }
    rsv_gpu_release(gpu, &block);
}

/// Minimum number of bytes that an application moves: each array once.
static size_t application_bytes(const rsv_device_transport *t)
{
    const rsv_device_system *s = &t->system;
    size_t nodes = s->node_count, entries = s->row_begin[nodes], tinted = s->tinted_begin[nodes];
    size_t rows = 2 * sizeof *s->row_begin + sizeof *s->scale + sizeof *s->parents.begin;
    size_t fields = 2 * sizeof(rsv_rgb) + sizeof *s->albedo + 2 * sizeof(rsv_rgb4);
    return rsv_gpu_diffusion_bytes(t) + nodes * (rows + fields) + entries * sizeof *s->column +
           tinted * (sizeof *s->tinted_column + sizeof *s->tinted_weight);
}

/// Applications per recording, so that launches cost as much as in a solver.
enum { APPLICATIONS = 4 };

static void measure_application(rsv_device_transport *t, uint32_t repetitions, double *seconds)
{
    rsv_gpu *gpu = t->gpu;
    rsv_gpu_transport_refresh(t);
    rsv_gpu_clear(gpu, t->solver.p, t->system.node_count * sizeof *t->solver.p);
    rsv_gpu_record(gpu);
    for (int k = 0; k < APPLICATIONS; k++)
        rsv_gpu_product(t, t->solver.p, t->solver.v, rsv_launch_gather);
    rsv_gpu_recording *recording = rsv_gpu_recorded(gpu);
    rsv_gpu_replay(gpu, recording); // caches and clocks as they are at work
    for (uint32_t k = 0; k < repetitions; k++) {
        rsv_gpu_mark(gpu, 0);
        rsv_gpu_replay(gpu, recording);
        rsv_gpu_mark(gpu, 1);
        seconds[k] = rsv_gpu_marked_seconds(gpu) / APPLICATIONS;
    }
    rsv_gpu_forget(recording);
}

rsv_status rsv_gpu_measure(rsv_device_transport *t, uint32_t repetitions, double *copy_rate,
    double *seconds, size_t *bytes, char *message)
{
    *bytes = application_bytes(t);
    measure_copy(t->gpu, repetitions, copy_rate);
    measure_application(t, repetitions, seconds);
    return rsv_gpu_wait(t->gpu, message);
}
