#include "sha256.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
#include <immintrin.h>
#define HAS_INSTRUCTIONS 1
#endif

/// Fractions of the cube roots of the first 64 primes.
static const uint32_t round_constant[64] = { 0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5,
    0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3,
    0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc,
    0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7,
    0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13,
    0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3,
    0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5,
    0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208,
    0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2 };

static uint32_t rotate(uint32_t x, int bits) { return x >> bits | x << (32 - bits); }

static void expand(const uint8_t *block, uint32_t *word)
{
    for (int t = 0; t < 16; t++)
        word[t] = (uint32_t)block[4 * t] << 24 | (uint32_t)block[4 * t + 1] << 16 |
                  (uint32_t)block[4 * t + 2] << 8 | block[4 * t + 3];
    for (int t = 16; t < 64; t++) {
        uint32_t a = word[t - 15], b = word[t - 2];
        uint32_t s0 = rotate(a, 7) ^ rotate(a, 18) ^ a >> 3;
        uint32_t s1 = rotate(b, 17) ^ rotate(b, 19) ^ b >> 10;
        word[t] = word[t - 16] + s0 + word[t - 7] + s1;
    }
}

static void compress(uint32_t *state, const uint8_t *block)
{
    uint32_t word[64], s[8];
    expand(block, word);
    memcpy(s, state, sizeof s);
    for (int t = 0; t < 64; t++) {
        uint32_t s1 = rotate(s[4], 6) ^ rotate(s[4], 11) ^ rotate(s[4], 25);
        uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
        uint32_t s0 = rotate(s[0], 2) ^ rotate(s[0], 13) ^ rotate(s[0], 22);
        uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
        uint32_t t1 = s[7] + s1 + choice + round_constant[t] + word[t];
        for (int k = 7; k > 0; k--) // unrolled, unlike a call of memmove
            s[k] = s[k - 1];
        s[4] += t1;
        s[0] = t1 + s0 + majority;
    }
    for (int k = 0; k < 8; k++)
        state[k] += s[k];
}

// ---- instructions for it ------------------------------------------------------------------------

#if defined(HAS_INSTRUCTIONS)

static bool has_instructions(void)
{
    unsigned a, b, c, d;
    if (!__builtin_cpu_supports("sse4.1") || !__get_cpuid_count(7, 0, &a, &b, &c, &d)) return false;
    return b >> 29 & 1;
}

/// Four rounds. @param state A, B, E, F and C, D, G, H, from the highest word down
__attribute__((target("sha,sse4.1"))) static inline void round_four(
    __m128i state[2], __m128i word, const uint32_t *constant)
{
    __m128i sum = _mm_add_epi32(word, _mm_loadu_si128((const __m128i *)constant));
    state[1] = _mm_sha256rnds2_epu32(state[1], state[0], sum);
    state[0] = _mm_sha256rnds2_epu32(state[0], state[1], _mm_shuffle_epi32(sum, 0x0e));
}

/// The next four words. @param word the 16 before, in and out
__attribute__((target("sha,sse4.1"))) static inline void expand_four(__m128i word[4])
{
    __m128i sum = _mm_sha256msg1_epu32(word[0], word[1]);
    sum = _mm_add_epi32(sum, _mm_alignr_epi8(word[3], word[2], 4));
    sum = _mm_sha256msg2_epu32(sum, word[3]);
    word[0] = word[1], word[1] = word[2], word[2] = word[3], word[3] = sum;
}

__attribute__((target("sha,sse4.1"))) static void compress_by_instructions(
    uint32_t *state, const uint8_t *block)
{
    const __m128i swap = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
    __m128i abcd = _mm_shuffle_epi32(_mm_loadu_si128((const __m128i *)state), 0xb1);
    __m128i efgh = _mm_shuffle_epi32(_mm_loadu_si128((const __m128i *)(state + 4)), 0x1b);
    __m128i word[4], s[2] = { _mm_alignr_epi8(abcd, efgh, 8), _mm_blend_epi16(efgh, abcd, 0xf0) };
    const __m128i before[2] = { s[0], s[1] };
    for (int k = 0; k < 4; k++) {
        word[k] = _mm_loadu_si128((const __m128i *)(block + 16 * k));
        word[k] = _mm_shuffle_epi8(word[k], swap);
        round_four(s, word[k], round_constant + 4 * k);
    }
    for (int t = 16; t < 64; t += 4) {
        expand_four(word);
        round_four(s, word[3], round_constant + t);
    }
    abcd = _mm_shuffle_epi32(_mm_add_epi32(s[0], before[0]), 0x1b);
    efgh = _mm_shuffle_epi32(_mm_add_epi32(s[1], before[1]), 0xb1);
    _mm_storeu_si128((__m128i *)state, _mm_blend_epi16(abcd, efgh, 0xf0));
    _mm_storeu_si128((__m128i *)(state + 4), _mm_alignr_epi8(efgh, abcd, 8));
}

#else

static bool has_instructions(void) { return false; }

static void compress_by_instructions(uint32_t *state, const uint8_t *block)
{
    compress(state, block);
}

#endif

// ---- all of it ----------------------------------------------------------------------------------

rsv_sha256 rsv_sha256_begin_portable(void)
{
    // fractions of the square roots of the first 8 primes
    return (rsv_sha256){ .state = { 0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f,
                             0x9b05688c, 0x1f83d9ab, 0x5be0cd19 },
        .compress = compress };
}

rsv_sha256 rsv_sha256_begin(void)
{
    rsv_sha256 hash = rsv_sha256_begin_portable();
    if (has_instructions()) hash.compress = compress_by_instructions;
    return hash;
}

void rsv_sha256_add(rsv_sha256 *hash, const void *data, size_t bytes)
{
    const uint8_t *next = data;
    while (bytes > 0) {
        size_t used = hash->byte_count % 64, part = 64 - used < bytes ? 64 - used : bytes;
        if (used == 0 && part == 64) {
            hash->compress(hash->state, next);
        } else {
            memcpy(hash->block + used, next, part);
            if (used + part == 64) hash->compress(hash->state, hash->block);
        }
        hash->byte_count += part;
        next += part;
        bytes -= part;
    }
}

void rsv_sha256_end(rsv_sha256 *hash, char *digits)
{
    static const uint8_t padding[64] = { 0x80 };
    uint64_t bits = 8 * hash->byte_count;
    uint8_t length[8];
    for (int k = 0; k < 8; k++)
        length[k] = (uint8_t)(bits >> (56 - 8 * k));
    size_t used = hash->byte_count % 64;
    rsv_sha256_add(hash, padding, used < 56 ? 56 - used : 120 - used);
    rsv_sha256_add(hash, length, sizeof length);
    for (int k = 0; k < 8; k++)
        snprintf(digits + 8 * k, 9, "%08x", hash->state[k]);
}
