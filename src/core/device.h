/// Interface between the library and device plug-ins. Rooms that can use a device declare a table of functions, and get
/// the plug-in's implementation through rsv_device_table.
#ifndef RSV_CORE_DEVICE_H
#define RSV_CORE_DEVICE_H

#include "resolvent/device.h"

#define RSV_DEVICE_MESSAGE_BYTES 512

/// The only exported symbol of a plug-in, and the interface version that it must report.
#define RSV_DEVICE_OPEN "rsv_gpu_open"
typedef rsv_status (*rsv_device_opener)(
    const char *version, const rsv_device_desc *desc, rsv_device **device, char *message);

/// Failures leave their text in `message` [RSV_DEVICE_MESSAGE_BYTES].
typedef struct rsv_device_table {
    void (*close)(rsv_device *device);
    const struct rsv_device_transport_table *transport; ///< solve/device_transport.h
    const struct rsv_device_basis_table *basis;         ///< relight/device_basis.h
    const struct rsv_device_rows_table *rows;           ///< operator/device_rows.h
    const struct rsv_device_direct_table *direct;       ///< direct/device_direct.h
    const struct rsv_device_shooting_table *shooting;   ///< direct/device_shooting.h
    const struct rsv_device_frames_table *frames;       ///< frame/device_frames.h
    const struct rsv_device_occlusion_table *occlusion; ///< occlusion/device_occlusion.h
} rsv_device_table;

struct rsv_device {
    const rsv_device_table *table;
    rsv_device_desc desc;
    rsv_device_info info;
};

/// The context's device; NULL = none, or it has failed.
rsv_device *rsv_context_device(const rsv_context *context);

/// Records that the device cannot do something. If the device is optional, this is a warning. Otherwise every
/// rsv_progress() returns the failure from now on. Callers that cannot return a status fall back to the CPU, so that no
/// result is ever wrong. After RSV_ERROR_DEVICE, the device is not used again.
/// @return RSV_OK if the device is optional, otherwise `status`
rsv_status rsv_device_failed(rsv_context *context, rsv_status status, const char *message);

#endif
