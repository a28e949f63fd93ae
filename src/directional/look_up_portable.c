#define RSV_KERNELS rsv_look_up_kernels_portable
#include "look_up_body.h"
