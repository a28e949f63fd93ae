/// Random and quasi-random numbers and the warps from the unit square; plain C, also for device code.
///
/// Nothing here has state. Every stream is a function of an item's index, so results do not depend on the number of
/// threads.
#ifndef RSV_SAMPLING_H
#define RSV_SAMPLING_H

#include "vec.h"

/// Bijective mix of 32 bits (Wellons' lowbias32).
RSV_INLINE uint32_t rsv_hash(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}
RSV_INLINE uint32_t rsv_hash2(uint32_t a, uint32_t b)
{
    return rsv_hash(a ^ rsv_hash(b + 0x9e3779b9u));
}
RSV_INLINE uint32_t rsv_hash3(uint32_t a, uint32_t b, uint32_t c)
{
    return rsv_hash2(a, rsv_hash2(b, c));
}

/// Uniform in [0, 1) from the high 24 bits.
RSV_INLINE float rsv_unit_float(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }

/// A small sequential generator (PCG32, O'Neill 2014) for chains of unknown length.
typedef struct rsv_random {
    uint64_t state;
} rsv_random;

RSV_INLINE uint32_t rsv_random_bits(rsv_random *random)
{
    uint64_t old = random->state;
    random->state = old * 6364136223846793005ull + 1442695040888963407ull;
    uint32_t shifted = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
}
RSV_INLINE rsv_random rsv_random_from(uint32_t a, uint32_t b, uint32_t c)
{
    rsv_random random = { ((uint64_t)rsv_hash3(a, b, c) << 32 | rsv_hash3(c ^ 0x68bc21ebu, a, b)) };
    rsv_random_bits(&random);
    return random;
}
RSV_INLINE float rsv_random_float(rsv_random *random)
{
    return rsv_unit_float(rsv_random_bits(random));
}

RSV_INLINE uint32_t rsv_reverse_bits(uint32_t x)
{
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/// Nested uniform (Owen) scrambling by a bit-reversed hash (Laine and Karras 2011, constants of
/// Vegdahl 2021).
RSV_INLINE uint32_t rsv_owen_scramble(uint32_t x, uint32_t seed)
{
    x = rsv_reverse_bits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return rsv_reverse_bits(x);
}

/// Second dimension of the Sobol sequence; the first is rsv_reverse_bits(index). Together they are a (0, 2)-sequence.
/// Its matrix is Pascal's triangle modulo 2, where entry (p, j) is 1 if the bits of p are among those of j (Lucas): bit
/// p of the result, from the top, sums the bits j of the index over these, one bit of p at a time.
RSV_INLINE uint32_t rsv_sobol_second(uint32_t index)
{
    uint32_t x = rsv_reverse_bits(index);
    x ^= x << 1 & 0xaaaaaaaau;
    x ^= x << 2 & 0xccccccccu;
    x ^= x << 4 & 0xf0f0f0f0u;
    x ^= x << 8 & 0xff00ff00u;
    return x ^ (x << 16 & 0xffff0000u);
}

/// Point `index` of an Owen-scrambled (0, 2)-sequence; different seeds are independent randomisations.
RSV_INLINE void rsv_sobol_2d(uint32_t index, uint32_t seed, float *x, float *y)
{
    // shuffling the index decorrelates pairs of dimensions that share it (Burley 2020)
    uint32_t shuffled = rsv_owen_scramble(index, rsv_hash2(seed, 2));
    *x = rsv_unit_float(rsv_owen_scramble(rsv_reverse_bits(shuffled), rsv_hash2(seed, 0)));
    *y = rsv_unit_float(rsv_owen_scramble(rsv_sobol_second(shuffled), rsv_hash2(seed, 1)));
}

/// Only the first coordinate of that point.
RSV_INLINE float rsv_sobol_1d(uint32_t index, uint32_t seed)
{
    uint32_t shuffled = rsv_owen_scramble(index, rsv_hash2(seed, 2));
    return rsv_unit_float(rsv_owen_scramble(rsv_reverse_bits(shuffled), rsv_hash2(seed, 0)));
}

/// Place `index` of a (0, 2)-sequence that starts at the centre of the unit square.
RSV_INLINE void rsv_shared_place(uint32_t index, float *x, float *y)
{
    *x = rsv_unit_float(rsv_reverse_bits(index) + 0x80000000u);
    *y = rsv_unit_float(rsv_sobol_second(index) + 0x80000000u);
}

/// Random number of a pixel, from which those of its samples come.
RSV_INLINE uint32_t rsv_pixel_seed(uint32_t seed, uint32_t row, uint32_t column)
{
    return rsv_hash3(seed ^ 0x6c078965u, row, column);
}

/// Entry of a cumulative table [count], from above 0 to its total, that holds `value`.
RSV_INLINE size_t rsv_interval_at(const double *cumulative, size_t count, double value)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (value < cumulative[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/// Entry of a cumulative table [count] that ends at 1 which holds *x; *x becomes its place within that entry, in [0,
/// 1).
RSV_INLINE uint32_t rsv_invert_cdf(const float *cdf, uint32_t count, float *x)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (*x < cdf[middle])
            high = middle;
        else
            low = middle + 1;
    }
    float begin = low ? cdf[low - 1] : 0, width = cdf[low] - begin;
    *x = width > 0 ? f_min(f_max((*x - begin) / width, 0), 0x1.fffffep-1f) : 0.5f;
    return low;
}

/// Uniform disk, area-preserving and continuous (Shirley and Chiu 1997).
RSV_INLINE void rsv_square_to_disk(float x, float y, float *dx, float *dy)
{
    float a = 2 * x - 1, b = 2 * y - 1;
    if (a == 0 && b == 0) {
        *dx = *dy = 0;
        return;
    }
    float r, phi;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = (RSV_PI / 4) * (b / a);
    } else {
        r = b;
        phi = (RSV_PI / 2) - (RSV_PI / 4) * (a / b);
    }
    *dx = r * cosf(phi);
    *dy = r * sinf(phi);
}

/// Cosine-distributed direction about +z; pdf_solid_angle = z / pi.
RSV_INLINE rsv_vec3 rsv_square_to_cosine_hemisphere(float x, float y)
{
    float dx, dy;
    rsv_square_to_disk(x, y, &dx, &dy);
    return v3(dx, dy, sqrtf(f_max(1 - dx * dx - dy * dy, 1e-12f)));
}

/// Uniform on a triangle: barycentric weights of corners 1 and 2 (Heitz 2019's low-distortion map).
RSV_INLINE void rsv_square_to_triangle(float x, float y, float *u, float *v)
{
    if (y > x) {
        float half = 0.5f * x;
        *u = half;
        *v = y - half;
    } else {
        float half = 0.5f * y;
        *u = x - half;
        *v = half;
    }
}

/// Uniform direction on the sphere.
RSV_INLINE rsv_vec3 rsv_square_to_sphere(float x, float y)
{
    float z = 1 - 2 * x, r = sqrtf(f_max(0, 1 - z * z)), phi = 2 * RSV_PI * y;
    return v3(r * cosf(phi), r * sinf(phi), z);
}

#endif
