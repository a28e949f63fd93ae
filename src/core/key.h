/// 64-bit hash keys of things, computed from their contents, so that they are the same in every version of a scene.
#ifndef RSV_KEY_H
#define RSV_KEY_H

#include "vec.h"

#include <string.h>

/// Extends a key by a word (the finalizer of SplitMix64, Steele et al. 2014).
RSV_INLINE uint64_t rsv_key_add(uint64_t key, uint64_t word)
{
    key = (key + 0x9e3779b97f4a7c15u) ^ word;
    key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9u;
    key = (key ^ key >> 27) * 0x94d049bb133111ebu;
    return key ^ key >> 31;
}

/// Followed by the bits of three numbers.
RSV_INLINE uint64_t rsv_key_add_vector(uint64_t key, rsv_vec3 v)
{
    uint32_t bits[3];
    memcpy(bits, &v, sizeof bits);
    return rsv_key_add(rsv_key_add(key, (uint64_t)bits[0] << 32 | bits[1]), bits[2]);
}

/// Followed by bytes: a check against accidents.
RSV_INLINE uint64_t rsv_key_add_bytes(uint64_t key, const void *data, size_t count)
{
    const uint8_t *next = (const uint8_t *)data;
    for (; count >= 8; count -= 8, next += 8) {
        uint64_t word;
        memcpy(&word, next, 8);
        key = rsv_key_add(key, word);
    }
    for (; count; count--)
        key = rsv_key_add(key, *next++);
    return key;
}

#endif
