/// Bits of words; plain C, also for device code.
#ifndef RSV_BITS_H
#define RSV_BITS_H

#include "vec.h"

/// Index of the lowest bit that is set. @param bits not 0
RSV_INLINE uint32_t rsv_lowest_bit(uint32_t bits)
{
#if defined(__CUDA_ARCH__)
    return (uint32_t)__ffs((int)bits) - 1;
#else
    return (uint32_t)__builtin_ctz(bits);
#endif
}

RSV_INLINE uint32_t rsv_count_bits(uint32_t bits)
{
#if defined(__CUDA_ARCH__)
    return (uint32_t)__popc(bits);
#else
    return (uint32_t)__builtin_popcount(bits);
#endif
}

#endif
