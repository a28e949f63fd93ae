/// Interface of plug-ins for relighting by factors; the library's side is rsv_device_basis in resolvent/device.h.
#ifndef RSV_DEVICE_BASIS_H
#define RSV_DEVICE_BASIS_H

#include "../core/device.h"

/// Failures leave their text in `message` [RSV_DEVICE_MESSAGE_BYTES].
typedef struct rsv_device_basis_table {
    rsv_status (*create)(rsv_device *device, uint32_t light_count, size_t receiver_count,
        const float *value, rsv_device_basis **basis, char *message);
    void (*destroy)(rsv_device_basis *basis);
    /// @param irradiance on the host; NULL = stays on the device
    rsv_status (*relight)(
        rsv_device_basis *basis, const rsv_rgb *scale, rsv_rgb *irradiance, char *message);
    const rsv_rgb *(*address)(const rsv_device_basis *basis);
    rsv_status (*measure)(
        rsv_device_basis *basis, uint32_t repetitions, double *seconds, char *message);
} rsv_device_basis_table;

#endif
