/// The operator on the device.
#ifndef RSV_GPU_TRANSPORT_H
#define RSV_GPU_TRANSPORT_H

#include "../solve/device_transport.h"
#include "transport_kernels.h"

struct rsv_device_transport {
    rsv_gpu *gpu;
    rsv_device_system system; ///< on the host
    size_t fields;            ///< that there is room for
    rsv_gpu_block rows, room;
    rsv_leave_args leave;
    rsv_gather_args gather;
    rsv_rgb *albedo; ///< [node_count] as are the next two
    float *scale;
    rsv_rgb *field, *source, *image; ///< [node_count x fields]
};

extern const rsv_device_transport_table rsv_gpu_transport;

/// Queues image = A field. Both on the device, [node_count].
void rsv_gpu_transport_apply(rsv_device_transport *transport, const rsv_rgb *field, rsv_rgb *image);

#endif
