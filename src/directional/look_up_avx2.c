#if defined(__x86_64__)
#define RSV_KERNELS rsv_look_up_kernels_avx2
#include "look_up_body.h"
#endif
