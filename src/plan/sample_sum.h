/// A picture as the mean of passes, and how noisy it is.
#ifndef RSV_SAMPLE_SUM_H
#define RSV_SAMPLE_SUM_H

#include "resolvent/render.h"

/// The first two passes have equally many samples, as pairs that join them have: their difference is what tells the noise.
typedef struct rsv_sample_sum {
    rsv_image *mean; ///< weighted by samples; NULL = no pass yet
    rsv_image *half[2];
    uint32_t *taken;       ///< [height * width] samples of each pixel; NULL = equally many
    uint32_t samples;      ///< of all passes, on average
    uint32_t half_samples; ///< of each half
} rsv_sample_sum;

/// Adds a pass, which it takes over; its first layer is what the noise is known of.
rsv_status rsv_sample_sum_add(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass);

/// Adds two passes of equally many samples, one to each half, as above: the first ones or, before any that is uneven, more.
rsv_status rsv_sample_sum_add_pair(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass[2]);

/// Adds a pass with its own number of samples for each pixel, as above. @param count [height * width]
rsv_status rsv_sample_sum_add_uneven(
    rsv_context *context, rsv_sample_sum *sum, const uint32_t *count, rsv_image *pass);

/// What a pixel counts at most in the noise: sparks count as much as edges of a bright window do.
#define RSV_MOST_OF_A_PIXEL 4

/// Squared errors fall with this power of the samples. Stratified pixels: edges with 1.5, noise of lights with 1. What gather
/// rays find is noise alone: with 1.2 the white room had 52 samples instead of 79, and twice the error that was promised.
#define RSV_STRATIFIED_FALL 1.2
#define RSV_GATHERED_FALL 1.0

/// Relative MSE by noise of the samples there are, equally many in all pixels. Needs two passes.
double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall);

/// Samples at which the relative MSE by noise is smaller by a factor. @param excess what it is now, over what is wanted
uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most);

void rsv_sample_sum_clear(rsv_context *context, rsv_sample_sum *sum);

#endif
