/// Ambient occlusion on the context's device, as long as it works. The caller does what it cannot do (core/device.h
/// describes how failures are reported).
#ifndef RSV_OCCLUSION_DEVICE_H
#define RSV_OCCLUSION_DEVICE_H

#include "device_occlusion.h"

typedef struct rsv_occlusion_device rsv_occlusion_device;

/// @param setting, screen (NULL = by rays) of the tracer's scene; all borrowed
/// @param made out; NULL = there is no device
/// @return the device's failure, unless it is optional
rsv_status rsv_occlusion_device_create(const rsv_tracer *tracer,
    const rsv_occlusion_setting *setting, const rsv_occlusion_screen *screen,
    rsv_occlusion_device **made);
void rsv_occlusion_device_destroy(rsv_occlusion_device *device);

/// Makes a picture. @param device NULL = there is none @param pixel [height * width]
/// @param seconds out: until the picture lay in the device's memory
/// @param done out: false = the caller has to do it @return the device's failure, unless it is optional
rsv_status rsv_occlusion_device_render(rsv_occlusion_device *device, const rsv_lens *lens,
    rsv_rgb *pixel, double *seconds, bool *done);

#endif
