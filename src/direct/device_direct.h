/// Direct light on a device: interface of the plug-in.
#ifndef RSV_DEVICE_DIRECT_H
#define RSV_DEVICE_DIRECT_H

#include "../bvh/bvh.h"
#include "../core/device.h"
#include "direct_sample.h"

/// Data common to all nodes. All of it is borrowed, and copied to the device.
typedef struct rsv_device_direct_desc {
    const rsv_scene_view *scene;
    rsv_bvh_view bvh;
    rsv_direct_setting setting;
    uint32_t most; ///< nodes at a time
} rsv_device_direct_desc;

typedef struct rsv_device_direct rsv_device_direct;

/// Failures set `message` [RSV_DEVICE_MESSAGE_BYTES] and leave results undefined.
typedef struct rsv_device_direct_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_direct_desc *desc,
        rsv_device_direct **direct, char *message);
    void (*destroy)(rsv_device_direct *direct);
    /// @param receivers [count] @param estimate [count] out
    rsv_status (*estimate)(rsv_device_direct *direct, const rsv_node_receivers *receivers,
        uint32_t count, rsv_direct_rays rays, rsv_direct_estimate *estimate, char *message);
} rsv_device_direct_table;

#endif
