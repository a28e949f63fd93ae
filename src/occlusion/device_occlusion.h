/// Ambient occlusion on a device: interface of the plug-in.
#ifndef RSV_DEVICE_OCCLUSION_H
#define RSV_DEVICE_OCCLUSION_H

#include "../bvh/bvh.h"
#include "../core/device.h"
#include "occlusion_screen.h"

/// A scene to make pictures of. All borrowed and copied to the device.
typedef struct rsv_device_occlusion_desc {
    const rsv_occlusion_setting *setting;
    const rsv_occlusion_screen *screen; ///< only its kernel and rotations; NULL = occlusion by rays
    rsv_bvh_view bvh;
} rsv_device_occlusion_desc;

typedef struct rsv_device_occlusion rsv_device_occlusion;

/// Failures set `message` [RSV_DEVICE_MESSAGE_BYTES] and leave results undefined.
typedef struct rsv_device_occlusion_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_occlusion_desc *desc,
        rsv_device_occlusion **occlusion, char *message);
    void (*destroy)(rsv_device_occlusion *occlusion);
    /// One camera ray per pixel, with its shading; the first starts a picture. In screen space there is only one.
    rsv_status (*render)(
        rsv_device_occlusion *occlusion, const rsv_lens *lens, uint32_t camera_ray, char *message);
    /// The picture so far. @param pixel [height * width]
    rsv_status (*picture)(rsv_device_occlusion *occlusion, rsv_rgb *pixel, char *message);
} rsv_device_occlusion_table;

#endif
