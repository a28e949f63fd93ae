#include "glance_kernels.h"

const rsv_glance_kernels *rsv_glance_kernels_best(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return &rsv_glance_kernels_avx512;
    if (__builtin_cpu_supports("avx2")) return &rsv_glance_kernels_avx2;
#endif
    return &rsv_glance_kernels_portable;
}
