/// Ambient occlusion on the device.
#ifndef RSV_GPU_OCCLUSION_H
#define RSV_GPU_OCCLUSION_H

#include "../occlusion/device_occlusion.h"

extern const rsv_device_occlusion_table rsv_gpu_occlusion;

#endif
