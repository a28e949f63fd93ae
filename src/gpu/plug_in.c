/// The plug-in's entrance.
#include "basis.h"
#include "direct.h"
#include "frames.h"
#include "occlusion.h"
#include "rows.h"
#include "shooting.h"
#include "transport.h"

#include <stdio.h>
#include <string.h>

static void close_device(rsv_device *device) { rsv_gpu_destroy((rsv_gpu *)device); }

static const rsv_device_table table = {
    .close = close_device,
    .transport = &rsv_gpu_transport,
    .basis = &rsv_gpu_basis,
    .frames = &rsv_gpu_frames,
    .rows = &rsv_gpu_rows,
    .direct = &rsv_gpu_direct,
    .shooting = &rsv_gpu_shooting,
    .occlusion = &rsv_gpu_occlusion,
};

/// As rsv_device_opener. The library checks the version because tables change between versions.
RSV_API rsv_status rsv_gpu_open(
    const char *version, const rsv_device_desc *desc, rsv_device **device, char *message);

rsv_status rsv_gpu_open(
    const char *version, const rsv_device_desc *desc, rsv_device **device, char *message)
{
    rsv_gpu *gpu = NULL;
    if (strcmp(version, RSV_VERSION_STRING) != 0) {
        snprintf(message, RSV_DEVICE_MESSAGE_BYTES,
            "the plug-in is of version " RSV_VERSION_STRING
            ", the program of %s; install both again",
            version);
        return RSV_ERROR_UNSUPPORTED;
    }
    rsv_status status = rsv_gpu_create(desc, &gpu, message);
    if (status != RSV_OK) return status;
    gpu->device.table = &table;
    gpu->device.desc = *desc;
    *device = &gpu->device;
    return RSV_OK;
}
