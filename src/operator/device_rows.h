/// The rays of rows of G on a device: what a plug-in gets, and what it offers.
#ifndef RSV_DEVICE_ROWS_H
#define RSV_DEVICE_ROWS_H

#include "../bvh/bvh.h"
#include "../core/device.h"
#include "../elements/elements.h"
#include "directions.h"
#include "row_rays.h"

/// What rows have in common. All borrowed and copied to the device.
typedef struct rsv_device_rows_desc {
    const rsv_scene_view *scene;
    rsv_bvh_view bvh;
    const rsv_elements *elements;
    const rsv_ray_target *target; ///< [2 * triangle_count] as in rsv_row_tracer
    const rsv_directions *directions;
    uint32_t seed;
    uint32_t most; ///< rows at a time
    bool sky;      ///< it matters which rays leave the scene
} rsv_device_rows_desc;

/// Ends of the rays of several rows, row by row.
typedef struct rsv_device_ends {
    uint32_t *column; ///< [most * rays] as in rsv_row_ends
    uint32_t *left;   ///< [most * rays] row * rays + ray
    rsv_hit *hit;     ///< [most * rays]
    size_t left_count;
} rsv_device_ends;

typedef struct rsv_device_rows rsv_device_rows;

/// Failures leave their text in `message` [RSV_DEVICE_MESSAGE_BYTES], and what should have come out undefined.
typedef struct rsv_device_rows_table {
    rsv_status (*create)(rsv_device *device, const rsv_device_rows_desc *desc,
        rsv_device_rows **rows, char *message);
    void (*destroy)(rsv_device_rows *rows);
    /// Traces their rays, as far as the first surface. @param receiver [count] @param ends filled
    rsv_status (*trace)(rsv_device_rows *rows, const rsv_row_receiver *receiver, uint32_t count,
        rsv_device_ends *ends, char *message);
} rsv_device_rows_table;

#endif
