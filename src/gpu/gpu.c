/// Shared by all devices.
#include "gpu.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/// Vector loads want 16, cache lines 128.
#define ALIGNMENT ((size_t)256)

void rsv_gpu_fail(rsv_gpu *gpu, rsv_status status, const char *format, ...)
{
    va_list arguments;
    if (gpu->status != RSV_OK) return;
    gpu->status = status;
    va_start(arguments, format);
    vsnprintf(gpu->message, sizeof gpu->message, format, arguments);
    va_end(arguments);
}

rsv_status rsv_gpu_report(rsv_gpu *gpu, char *message)
{
    rsv_status status = gpu->status;
    if (status != RSV_OK) snprintf(message, RSV_DEVICE_MESSAGE_BYTES, "%s", gpu->message);
    if (status != RSV_ERROR_DEVICE) gpu->status = RSV_OK;
    return status;
}

rsv_status rsv_gpu_check_capability(const rsv_device_info *info, int major, char *message)
{
    if (major >= RSV_GPU_OLDEST) return RSV_OK;
    snprintf(message, RSV_DEVICE_MESSAGE_BYTES,
        "%s has compute capability %s; it takes %d.0 or newer", info->name, info->capability,
        RSV_GPU_OLDEST);
    return RSV_ERROR_UNSUPPORTED;
}

void *rsv_gpu_new(size_t bytes, char *message)
{
    void *task = calloc(1, bytes);
    if (!task) snprintf(message, RSV_DEVICE_MESSAGE_BYTES, "out of memory");
    return task;
}

void *rsv_gpu_place(rsv_gpu_block *block, size_t count, size_t size)
{
    size_t at = block->placed;
    if (size > 0 && count > (SIZE_MAX - at - ALIGNMENT) / size)
        block->placed = SIZE_MAX - ALIGNMENT; // more than any device has
    else
        block->placed = (at + count * size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (block->base) return block->base + at;
    block->bytes = block->placed;
    return NULL;
}

void rsv_gpu_lay_out(
    rsv_gpu *gpu, rsv_gpu_block *block, rsv_gpu_layout layout, void *task, const char *what)
{
    layout(task, block);
    rsv_gpu_reserve(gpu, block, what);
    layout(task, block);
}

void rsv_gpu_upload_all(rsv_gpu *gpu, const rsv_gpu_array *array, size_t count)
{
    for (size_t k = 0; k < count; k++)
        rsv_gpu_upload(gpu, (void *)array[k].to, array[k].from, array[k].count * array[k].size);
}
