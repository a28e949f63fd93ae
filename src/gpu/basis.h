/// Relighting by factors on the device.
#ifndef RSV_GPU_BASIS_H
#define RSV_GPU_BASIS_H

#include "../relight/device_basis.h"
#include "gpu.h"

extern const rsv_device_basis_table rsv_gpu_basis;

#endif
