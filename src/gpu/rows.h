/// Rays of rows of G on the device.
#ifndef RSV_GPU_ROWS_H
#define RSV_GPU_ROWS_H

#include "../operator/device_rows.h"

extern const rsv_device_rows_table rsv_gpu_rows;

#endif
