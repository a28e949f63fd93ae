#include "basis.h"

#include "basis_kernels.h"

#include <stdlib.h>

struct rsv_device_basis {
    rsv_device *device; ///< first, for the library
    rsv_gpu_block block;
    rsv_basis_args args;
    float *value, *scale;
};

static rsv_gpu *gpu_of(const rsv_device_basis *b) { return (rsv_gpu *)b->device; }

static void lay_out(void *task, rsv_gpu_block *block)
{
    rsv_device_basis *b = task;
    rsv_basis_args *a = &b->args;
    a->value = b->value = rsv_gpu_place(block, a->light_count, a->float_count * sizeof *b->value);
    a->scale = b->scale = rsv_gpu_place(block, a->light_count, 3 * sizeof *b->scale);
    a->out = rsv_gpu_place(block, a->float_count, sizeof *a->out);
}

static void destroy(rsv_device_basis *b)
{
    rsv_gpu_release(gpu_of(b), &b->block);
    free(b);
}

static rsv_status create(rsv_device *device, uint32_t light_count, size_t receiver_count,
    const float *value, rsv_device_basis **basis, char *message)
{
    rsv_device_basis *b = rsv_gpu_new(sizeof *b, message);
    rsv_gpu *gpu = (rsv_gpu *)device;
    if (!b) return RSV_ERROR_MEMORY;
    b->device = device;
    b->args.light_count = light_count;
    b->args.float_count = 3 * receiver_count;
    rsv_gpu_lay_out(gpu, &b->block, lay_out, b, "the basis of lights");
    rsv_gpu_upload(gpu, b->value, value, light_count * b->args.float_count * sizeof *value);
    rsv_status status = rsv_gpu_wait(gpu, message);
    if (status == RSV_OK)
        *basis = b;
    else
        destroy(b);
    return status;
}

static rsv_status relight(
    rsv_device_basis *b, const rsv_rgb *scale, rsv_rgb *irradiance, char *message)
{
    rsv_gpu *gpu = gpu_of(b);
    rsv_gpu_upload(gpu, b->scale, scale, b->args.light_count * sizeof *scale);
    rsv_launch_basis(gpu, &b->args, b->args.float_count);
    if (irradiance)
        rsv_gpu_download(gpu, irradiance, b->args.out, b->args.float_count * sizeof(float));
    return rsv_gpu_wait(gpu, message);
}

static const rsv_rgb *address(const rsv_device_basis *b) { return (const rsv_rgb *)b->args.out; }

/// Uploads all factors again each time.
static rsv_status measure(rsv_device_basis *b, uint32_t repetitions, double *seconds, char *message)
{
    rsv_gpu *gpu = gpu_of(b);
    float *scale = calloc(b->args.light_count, 3 * sizeof *scale);
    if (!scale) rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, "out of memory");
    for (uint32_t k = 0; k < repetitions && scale; k++) {
        rsv_gpu_mark(gpu, 0);
        rsv_gpu_upload(gpu, b->scale, scale, b->args.light_count * 3 * sizeof *scale);
        rsv_launch_basis(gpu, &b->args, b->args.float_count);
        rsv_gpu_mark(gpu, 1);
        seconds[k] = rsv_gpu_marked_seconds(gpu);
    }
    free(scale);
    return rsv_gpu_wait(gpu, message);
}

const rsv_device_basis_table rsv_gpu_basis = { create, destroy, relight, address, measure };
