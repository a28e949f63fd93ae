/// Kernels for the device.
#define RSV_KERNELS_HERE
#include "transport_kernels.h"
