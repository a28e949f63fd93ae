/// The linear map A = G K on a device: interface of the plug-in.
#ifndef RSV_DEVICE_TRANSPORT_H
#define RSV_DEVICE_TRANSPORT_H

#include "../core/device.h"
#include "diffusion_rows.h"
#include "parents.h"
#include "resolvent/solve.h"

/// All borrowed. Rows and parents are copied to the device once; `scale` and `albedo` are read again by each call,
/// since relighting and lossless pockets change them.
typedef struct rsv_device_system {
    size_t node_count;
    const size_t *row_begin, *tinted_begin; ///< [node_count + 1] where rows begin
    const uint32_t *column, *tinted_column;
    const rsv_rgb *tinted_weight;
    const float *scale;    ///< [node_count]
    const rsv_rgb *albedo; ///< [node_count]
    rsv_parents parents;
    const rsv_diffusion_rows *diffusion; ///< NULL = light leaves where it entered, everywhere
} rsv_device_system;

typedef struct rsv_device_transport rsv_device_transport;

/// Request for a correction d with (I - A) d close to a residual, and its result.
typedef struct rsv_device_solve {
    rsv_solver solver;         ///< one of those the device has
    double relative;           ///< max |new residual| over max |residual|, channel by channel
    double max_applications;   ///< of A
    bool (*stops)(void *user); ///< polled
    void *user;
    double applications; ///< out
    bool converged;      ///< out
} rsv_device_solve;

/// Fields are [node_count x fields], node by node. Failures set `message` [RSV_DEVICE_MESSAGE_BYTES] and leave results
/// undefined.
typedef struct rsv_device_transport_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_system *system,
        rsv_device_transport **transport, char *message);
    void (*destroy)(rsv_device_transport *transport);
    /// image = A field
    rsv_status (*apply)(rsv_device_transport *transport, size_t fields, const rsv_rgb *field,
        rsv_rgb *image, char *message);
    /// residual = source + A field - field, with sums in double
    rsv_status (*residual)(rsv_device_transport *transport, size_t fields, const rsv_rgb *source,
        const rsv_rgb *field, rsv_rgb *residual, char *message);
    /// Whether the device has this solver.
    bool (*solves)(rsv_solver solver);
    /// Solves for one field. @param correction out: the best that was found, converged or not
    rsv_status (*solve)(rsv_device_transport *transport, rsv_device_solve *solve,
        const rsv_rgb *residual, rsv_rgb *correction, char *message);
    /// As rsv_measure_device.
    rsv_status (*measure)(rsv_device_transport *transport, uint32_t repetitions, double *copy_rate,
        double *seconds, size_t *bytes, char *message);
} rsv_device_transport_table;

#endif
