#include "preview_kernels.h"

#include "../core/instructions.h"

const rsv_preview_kernels *rsv_preview_kernels_best(void)
{
#if defined(RSV_HAS_X86_KERNELS)
    if (rsv_kernels_for_avx512()) return &rsv_preview_kernels_avx512;
    if (rsv_kernels_for_avx2()) return &rsv_preview_kernels_avx2;
#endif
    return &rsv_preview_kernels_portable;
}
