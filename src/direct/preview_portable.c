#define RSV_KERNELS rsv_preview_kernels_portable
#include "preview_kernels_body.h"
