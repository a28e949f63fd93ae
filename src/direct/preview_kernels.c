#include "preview_kernels.h"

#include "../core/instructions.h"

const rsv_preview_kernels *rsv_preview_kernels_best(void)
{
#if defined(__x86_64__)
    if (rsv_cpu_has_avx512()) return &rsv_preview_kernels_avx512;
    if (rsv_cpu_has_avx2()) return &rsv_preview_kernels_avx2;
#endif
    return &rsv_preview_kernels_portable;
}
