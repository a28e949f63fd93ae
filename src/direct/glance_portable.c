#define RSV_KERNELS rsv_glance_kernels_portable
#include "glance_kernels_body.h"
