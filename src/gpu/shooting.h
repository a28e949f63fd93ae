/// Light shooting on the device.
#ifndef RSV_GPU_SHOOTING_H
#define RSV_GPU_SHOOTING_H

#include "../direct/device_shooting.h"

extern const rsv_device_shooting_table rsv_gpu_shooting;

#endif
