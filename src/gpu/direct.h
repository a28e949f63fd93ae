/// Direct light on the device.
#ifndef RSV_GPU_DIRECT_H
#define RSV_GPU_DIRECT_H

#include "../direct/device_direct.h"

extern const rsv_device_direct_table rsv_gpu_direct;

#endif
