/// One of the samples of a pixel. Their random numbers are stratified.
#ifndef RSV_PIXEL_SAMPLE_H
#define RSV_PIXEL_SAMPLE_H

#include "../core/stratified.h"

typedef struct rsv_pixel_sample {
    uint32_t index, count; ///< of the sample, and of all in the pixel
    uint32_t seed;         ///< of the pixel
} rsv_pixel_sample;

/// @param dimension distinguishes the random numbers of one sample
RSV_INLINE float rsv_pixel_sample_1d(rsv_pixel_sample sample, uint32_t dimension)
{
    return rsv_stratified_1d(sample.index, sample.count, rsv_hash2(sample.seed, dimension));
}

RSV_INLINE void rsv_pixel_sample_2d(rsv_pixel_sample sample, uint32_t dimension, float *x, float *y)
{
    rsv_stratified_2d(sample.index, sample.count, rsv_hash2(sample.seed, dimension), x, y);
}

/// Edge of a sample's share of its pixel: normals are averaged over no more, as the light that they receive is no mean
/// of theirs. @param width of the pixel, metres
RSV_INLINE float rsv_width_of_sample(float width, rsv_pixel_sample sample)
{
    return width / sqrtf((float)sample.count);
}

#endif
