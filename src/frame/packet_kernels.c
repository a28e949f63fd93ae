#include "packet_kernels.h"

#include "../core/instructions.h"

static const char *const names[] = { "best", "portable", "avx2", "avx512" };

const char *rsv_instructions_name(rsv_instructions instructions)
{
    return (size_t)instructions < sizeof names / sizeof names[0] ? names[instructions] : NULL;
}

bool rsv_has_instructions(rsv_instructions instructions)
{
    if (instructions == RSV_INSTRUCTIONS_AVX2) return rsv_kernels_for_avx2();
    if (instructions == RSV_INSTRUCTIONS_AVX512) return rsv_kernels_for_avx512();
    return instructions <= RSV_INSTRUCTIONS_PORTABLE;
}

const rsv_packet_kernels *rsv_packet_kernels_for(rsv_instructions *instructions)
{
    if (*instructions == RSV_INSTRUCTIONS_BEST) {
        *instructions = RSV_INSTRUCTIONS_AVX512;
        while (!rsv_has_instructions(*instructions))
            --*instructions;
    }
#if defined(RSV_HAS_X86_KERNELS)
    if (*instructions == RSV_INSTRUCTIONS_AVX512) return &rsv_packet_kernels_avx512;
    if (*instructions == RSV_INSTRUCTIONS_AVX2) return &rsv_packet_kernels_avx2;
#endif
    return &rsv_packet_kernels_portable;
}
