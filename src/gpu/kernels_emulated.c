/// Kernels for the emulated device.
#define RSV_KERNELS_HERE
#include "transport_kernels.h"
