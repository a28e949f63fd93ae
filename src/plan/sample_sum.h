/// A picture as the mean of passes, and how noisy it is.
#ifndef RSV_SAMPLE_SUM_H
#define RSV_SAMPLE_SUM_H

#include "resolvent/render.h"

/// The first two passes have equally many samples, and so do the pairs that join them: their difference gives the
/// noise.
typedef struct rsv_sample_sum {
    rsv_image *mean; ///< weighted by samples; NULL = no pass yet
    rsv_image *half[2];
    uint32_t *taken;       ///< [height * width] samples of each pixel; NULL = equally many
    uint32_t samples;      ///< of all passes, on average
    uint32_t half_samples; ///< of each half
} rsv_sample_sum;

/// Adds a pass, which it then owns. Its first layer is used for the noise.
rsv_status rsv_sample_sum_add(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass);

/// Adds two passes of equally many samples, one to each half, as above: the first ones or, before any that is uneven,
/// more.
rsv_status rsv_sample_sum_add_pair(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass[2]);

/// Adds a pass with its own number of samples for each pixel, as above. @param count [height * width]
rsv_status rsv_sample_sum_add_uneven(
    rsv_context *context, rsv_sample_sum *sum, const uint32_t *count, rsv_image *pass);

/// Maximum weight of a pixel in the noise: sparks weigh as much as edges of a bright window.
#define RSV_MOST_OF_A_PIXEL 4

/// Squared errors decrease with this power of the samples. With stratified pixels, edges decrease with 1.5 and noise of
/// lights with 1. Gather rays have only noise: with 1.2, the white room had 52 samples instead of 79, and twice the
/// requested error.
#define RSV_STRATIFIED_FALL 1.2
#define RSV_GATHERED_FALL 1.0

/// Relative MSE by noise of the samples there are, equally many in all pixels. Needs two passes.
double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall);

/// Number of samples at which the relative MSE due to noise is lower by a factor. @param excess present MSE / target
uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most);

void rsv_sample_sum_clear(rsv_context *context, rsv_sample_sum *sum);

#endif
