/// Optional instructions of the CPU that kernels use.
#ifndef RSV_INSTRUCTIONS_H
#define RSV_INSTRUCTIONS_H

#include <stdbool.h>

/// Whether kernels are also compiled for them. Sanitizers, which watch the source that all of them share, see the
/// portable ones.
#if defined(__x86_64__) && !defined(RSV_PORTABLE_KERNELS)
#define RSV_HAS_X86_KERNELS
#endif

static inline bool rsv_kernels_for_avx2(void)
{
#if defined(RSV_HAS_X86_KERNELS)
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2");
#else
    return false;
#endif
}

/// The parts of it that they are compiled for.
static inline bool rsv_kernels_for_avx512(void)
{
#if defined(RSV_HAS_X86_KERNELS)
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
    return false;
#endif
}

#endif
