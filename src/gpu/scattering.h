/// How the materials of a scene scatter, on the device.
#ifndef RSV_GPU_SCATTERING_H
#define RSV_GPU_SCATTERING_H

#include "../bsdf/bsdf.h"
#include "gpu.h"

typedef struct rsv_gpu_scattering {
    size_t count;            ///< materials
    rsv_bsdf *host;          ///< [count] as they are uploaded
    rsv_bsdf *bsdf;          ///< [count] on the device
    rsv_bsdf_tables *tables; ///< on the device
} rsv_gpu_scattering;

/// @param message of a failure, [RSV_DEVICE_MESSAGE_BYTES]
rsv_status rsv_gpu_scattering_create(size_t count, rsv_gpu_scattering *scattering, char *message);
void rsv_gpu_scattering_destroy(rsv_gpu_scattering *scattering);

/// Part of a task's layout.
void rsv_gpu_scattering_place(rsv_gpu_scattering *scattering, rsv_gpu_block *block);
/// Again after edits. @param bsdf [count]
void rsv_gpu_scattering_upload(
    const rsv_gpu_scattering *scattering, const rsv_bsdf *bsdf, rsv_gpu *gpu);

#endif
