/// Frames on the context's device, as long as it works. The caller does what it cannot do (core/device.h describes how
/// failures are reported).
#ifndef RSV_FRAME_DEVICE_H
#define RSV_FRAME_DEVICE_H

#include "device_frames.h"
#include "frame_tile.h"

typedef struct rsv_frame_device rsv_frame_device;

/// @param table borrowed @param made out; NULL = there is no device, or it cannot show this scene, which is logged
/// @return the device's failure, unless it is optional
rsv_status rsv_frame_device_create(
    const rsv_light_table *table, const rsv_frame_desc *desc, rsv_frame_device **made);
void rsv_frame_device_destroy(rsv_frame_device *device);

/// The table's light has changed.
void rsv_frame_device_refresh(rsv_frame_device *device);

/// Adds one sample to each pixel. @param device NULL = there is none @param eye [eyes]
/// @param done out: false = the caller has to do it @return the device's failure, unless it is optional
rsv_status rsv_frame_device_render(
    rsv_frame_device *device, const rsv_eye_picture *eye, uint64_t *path_rays, bool *done);

/// Brings the last frame: its codes, unless `pixel` has them from an earlier call, and its sums.
/// @param pixel, sum [height * width]
void rsv_frame_device_pixels(rsv_frame_device *device, uint32_t eye, uint8_t (*pixel)[4]);
void rsv_frame_device_sums(rsv_frame_device *device, uint32_t eye, float (*sum)[4]);

#endif
