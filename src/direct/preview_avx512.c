#if defined(__x86_64__)
#define RSV_KERNELS rsv_preview_kernels_avx512
#include "preview_kernels_body.h"
#endif
