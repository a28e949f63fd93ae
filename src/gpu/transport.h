/// The operator on the device.
#ifndef RSV_GPU_TRANSPORT_H
#define RSV_GPU_TRANSPORT_H

#include "../solve/device_transport.h"
#include "diffusion_kernels.h"
#include "solver_kernels.h"

#define RSV_GPU_SOLVERS 8 ///< at most

struct rsv_device_transport {
    rsv_gpu *gpu;
    rsv_device_system system; ///< on the host
    size_t fields;            ///< that there is room for
    rsv_gpu_block rows, room;
    rsv_leave_args leave;
    rsv_gather_args gather;
    rsv_diffuse_args diffuse; ///< where system.diffusion is
    rsv_rgb *albedo;          ///< [node_count] as are the next two
    float *scale;
    rsv_rgb *field, *source, *image; ///< [node_count x fields]
    rsv_solver_args solver;          ///< arrays of the solvers, [node_count]
    rsv_gpu_recording
        *steps[RSV_GPU_SOLVERS]; ///< some steps of each of them; NULL = not yet recorded
};

extern const rsv_device_transport_table rsv_gpu_transport;

typedef void (*rsv_gather_launch)(rsv_gpu *gpu, const rsv_gather_args *args, size_t count);

/// Queues a product of one field on the device, [node_count]: image = A field, or another result of `launch`.
void rsv_gpu_product(rsv_device_transport *transport, const rsv_rgb *field, rsv_rgb *image,
    rsv_gather_launch launch);

/// Uploads everything that may have changed since the last call.
void rsv_gpu_transport_refresh(rsv_device_transport *transport);

/// Diffusion below the surfaces of translucent bodies; all of it nothing where there are none.
void rsv_gpu_diffusion_lay_out(rsv_device_transport *transport, rsv_gpu_block *block);
void rsv_gpu_diffusion_upload(rsv_device_transport *transport);
size_t rsv_gpu_diffusion_bytes(const rsv_device_transport *transport); ///< that it must move
/// Queues diffuse.diffused = P field where there are bodies. @param entering its field counts
void rsv_gpu_diffuse(rsv_device_transport *transport, const rsv_leave_args *entering);

/// Arrays of the solvers, for the layout of the transport.
void rsv_gpu_solver_lay_out(rsv_device_transport *transport, rsv_gpu_block *block);

/// As rsv_device_transport_table.measure.
rsv_status rsv_gpu_measure(rsv_device_transport *transport, uint32_t repetitions, double *copy_rate,
    double *seconds, size_t *bytes, char *message);

/// As rsv_device_transport_table.solves and solve.
bool rsv_gpu_solves(rsv_solver solver);
rsv_status rsv_gpu_solve(rsv_device_transport *transport, rsv_device_solve *solve,
    const rsv_rgb *residual, rsv_rgb *correction, char *message);

#endif
