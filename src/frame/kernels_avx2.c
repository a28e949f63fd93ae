#if defined(__x86_64__)
#define RSV_KERNELS rsv_packet_kernels_avx2
#include "packet_kernels_body.h"
#endif
