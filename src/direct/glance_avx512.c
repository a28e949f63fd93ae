#if defined(__x86_64__)
#define RSV_KERNELS rsv_glance_kernels_avx512
#include "glance_kernels_body.h"
#endif
