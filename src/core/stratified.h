/// Correlated multi-jittered samples (Kensler 2013): stratified in two dimensions at once for any count;
/// plain C, also for device code.
#ifndef RSV_STRATIFIED_H
#define RSV_STRATIFIED_H

#include "sampling.h"

/// The `index`-th element of a random permutation of 0 .. count-1, without storing it (cycle walking).
RSV_INLINE uint32_t rsv_permute(uint32_t index, uint32_t count, uint32_t seed)
{
    uint32_t mask = count - 1;
    mask |= mask >> 1;
    mask |= mask >> 2;
    mask |= mask >> 4;
    mask |= mask >> 8;
    mask |= mask >> 16;
    do {
        index ^= seed;
        index *= 0xe170893du;
        index ^= seed >> 16;
        index ^= (index & mask) >> 4;
        index ^= seed >> 8;
        index *= 0x0929eb3fu;
        index ^= seed >> 23;
        index ^= (index & mask) >> 1;
        index *= 1 | seed >> 27;
        index *= 0x6935fa69u;
        index ^= (index & mask) >> 11;
        index *= 0x74dcb303u;
        index ^= (index & mask) >> 2;
        index *= 0x9e501cc3u;
        index ^= (index & mask) >> 2;
        index *= 0xc860a3dfu;
        index &= mask;
        index ^= index >> 5;
    } while (index >= count);
    return (index + seed) % count;
}

/// Sample `index` of `count` in one dimension, in random order.
RSV_INLINE float rsv_stratified_1d(uint32_t index, uint32_t count, uint32_t seed)
{
    float jitter = rsv_unit_float(rsv_hash2(seed ^ 0x2c1b3c6du, index));
    float x = ((float)rsv_permute(index, count, seed) + jitter) / (float)count;
    return f_min(x, 0x1.fffffep-1f);
}

/// Sample `index` of `count` in two dimensions, in random order.
RSV_INLINE void rsv_stratified_2d(uint32_t index, uint32_t count, uint32_t seed, float *x, float *y)
{
    uint32_t columns = (uint32_t)sqrtf((float)count), rows = (count + columns - 1) / columns;
    uint32_t s = rsv_permute(index, count, seed * 0x51633e2du + 1);
    uint32_t sx = rsv_permute(s % columns, columns, seed * 0x68bc21ebu + 2);
    uint32_t sy = rsv_permute(s / columns, rows, seed * 0x02e5be93u + 3);
    float jx = rsv_unit_float(rsv_hash3(s, seed, 4)), jy = rsv_unit_float(rsv_hash3(s, seed, 5));
    *x = f_min(((float)sx + ((float)sy + jx) / (float)rows) / (float)columns, 0x1.fffffep-1f);
    *y = f_min(((float)s + jy) / (float)count, 0x1.fffffep-1f);
}

#endif
