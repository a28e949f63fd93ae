/// Optional instructions of the CPU.
#ifndef RSV_INSTRUCTIONS_H
#define RSV_INSTRUCTIONS_H

#include <stdbool.h>

static inline bool rsv_cpu_has_avx2(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2");
#else
    return false;
#endif
}

/// The parts of it that kernels are compiled for.
static inline bool rsv_cpu_has_avx512(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
    return false;
#endif
}

#endif
