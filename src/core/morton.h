/// Morton's curve through space: numbers of neighbouring cells lie close together, mostly.
#ifndef RSV_MORTON_H
#define RSV_MORTON_H

#include <stdint.h>

#define RSV_MORTON_BITS 21 ///< cells along each axis: 2^21

/// Two zeros ahead of each bit.
static inline uint64_t rsv_morton_spread(uint64_t x)
{
    x = (x | x << 32) & 0x001f00000000ffffu;
    x = (x | x << 16) & 0x001f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

/// Number of a cell of 2^bits along each axis; places outside count as at the border.
/// @param x, y, z in [0, 1]
static inline uint64_t rsv_morton_key(float x, float y, float z, int bits)
{
    const float place[3] = { x, y, z };
    uint64_t key = 0;
    for (int axis = 0; axis < 3; axis++) {
        float step = place[axis] * (float)(1 << bits), last = (float)((1 << bits) - 1);
        step = step > 0 ? step : 0;
        key |= rsv_morton_spread((uint64_t)(step < last ? step : last)) << axis;
    }
    return key;
}

#endif
