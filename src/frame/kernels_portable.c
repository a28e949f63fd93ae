#define RSV_KERNELS rsv_packet_kernels_portable
#include "packet_kernels_body.h"
