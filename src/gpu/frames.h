/// Frames on the device.
#ifndef RSV_GPU_FRAMES_H
#define RSV_GPU_FRAMES_H

#include "../frame/device_frames.h"

extern const rsv_device_frames_table rsv_gpu_frames;

#endif
