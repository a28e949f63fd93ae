#include "packet_kernels.h"

static const char *const names[] = { "best", "portable", "avx2", "avx512" };

const char *rsv_instructions_name(rsv_instructions instructions)
{
    return (size_t)instructions < sizeof names / sizeof names[0] ? names[instructions] : NULL;
}

bool rsv_has_instructions(rsv_instructions instructions)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (instructions == RSV_INSTRUCTIONS_AVX2) return __builtin_cpu_supports("avx2");
    if (instructions == RSV_INSTRUCTIONS_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#endif
    return instructions <= RSV_INSTRUCTIONS_PORTABLE;
}

const rsv_packet_kernels *rsv_packet_kernels_for(rsv_instructions *instructions)
{
    if (*instructions == RSV_INSTRUCTIONS_BEST) {
        *instructions = RSV_INSTRUCTIONS_AVX512;
        while (!rsv_has_instructions(*instructions))
            --*instructions;
    }
#if defined(__x86_64__)
    if (*instructions == RSV_INSTRUCTIONS_AVX512) return &rsv_packet_kernels_avx512;
    if (*instructions == RSV_INSTRUCTIONS_AVX2) return &rsv_packet_kernels_avx2;
#endif
    return &rsv_packet_kernels_portable;
}
