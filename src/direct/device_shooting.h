/// Photon tracing on a device: interface of the plug-in.
#ifndef RSV_DEVICE_SHOOTING_H
#define RSV_DEVICE_SHOOTING_H

#include "../bvh/bvh.h"
#include "../core/device.h"
#include "photon_path.h"

#define RSV_DEVICE_MAPS 2

/// Data common to all photons. All of it is borrowed, and copied to the device.
typedef struct rsv_device_shooting_desc {
    rsv_shooting shooting;
    rsv_bvh_view bvh;
    const rsv_lights *lights;
    const rsv_photon_source *source; ///< [source_count] with their guides
    size_t source_count;
    const rsv_photon_map *map; ///< [map_count] the maps to fill: their elements and units
    size_t map_count;          ///< RSV_DEVICE_MAPS at most
} rsv_device_shooting_desc;

typedef struct rsv_device_shooting rsv_device_shooting;

/// Failures set `message` [RSV_DEVICE_MESSAGE_BYTES] and leave results undefined.
typedef struct rsv_device_shooting_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_shooting_desc *desc,
        rsv_device_shooting **shooting, char *message);
    void (*destroy)(rsv_device_shooting *shooting);
    /// Shoots photons [first, first + photons) of `count` from a source.
    rsv_status (*shoot)(rsv_device_shooting *shooting, uint32_t source, uint32_t first,
        uint32_t photons, uint32_t count, char *message);
    /// The flux that all photons have left, in integers, so that it does not depend on their order.
    /// @param map [map_count] its sums are set @param rays out
    rsv_status (*collect)(
        rsv_device_shooting *shooting, const rsv_photon_map *map, uint64_t *rays, char *message);
} rsv_device_shooting_table;

#endif
