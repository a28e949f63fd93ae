/// A picture as the mean of passes, and how noisy it is.
#ifndef RSV_SAMPLE_SUM_H
#define RSV_SAMPLE_SUM_H

#include "resolvent/render.h"

/// A pixel whose number of samples is its own.
typedef struct rsv_summed_pixel {
    uint32_t taken; ///< samples in its mean
    uint32_t looks; ///< samples of passes that its variance was estimated from
    float variance; ///< relative squared error of one sample
    float left;     ///< part of this variance that its mean has
} rsv_summed_pixel;

/// Passes come in pairs, the halves of one stratified picture: their difference gives the noise.
typedef struct rsv_sample_sum {
    rsv_image *mean;    ///< weighted by samples; NULL = no pass yet
    rsv_image *half[2]; ///< the first two passes
    rsv_image *side[2]; ///< sums of every other pass, with guides, if passes have them; NULL = none
    uint32_t *side_samples[2]; ///< [height * width] of these; NULL = half_samples
    rsv_summed_pixel *pixel;   ///< [height * width]; NULL = equally many samples in all
    float *
        filtered_error; ///< [height * width] relative squared error left by the filter; NULL = without it
    rsv_image *clean; ///< the filtered picture; NULL = not filtered since the last pass
    float *kept; ///< [height * width] what part of the noise of samples that is; NULL = without it
    uint8_t
        *is_outline; ///< [height * width] pixels that get at least RSV_OUTLINE_SAMPLES; NULL = none
    uint32_t samples;      ///< of all passes, on average
    uint32_t half_samples; ///< of each half
} rsv_sample_sum;

/// Camera rays of pixels on outlines at least: with 4, the lower edge of a lamp is dotted.
#define RSV_OUTLINE_SAMPLES 16

/// Adds a pass, which it then owns. Its first layer is used for the noise.
rsv_status rsv_sample_sum_add(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass);

/// Makes the number of samples each pixel's own. Needs two passes; later ones must be uneven. @param fall of errors
rsv_status rsv_sample_sum_part(rsv_context *context, rsv_sample_sum *sum, double fall);

/// Samples of two passes that are each pixel's own.
typedef struct rsv_uneven_pair {
    const uint32_t *count; ///< [height * width] of both
    /// [height * width] 0 = they join those before. Else they replace them, and this is the variance expected of one
    const float *renewed;
    double fall; ///< of errors
} rsv_uneven_pair;

/// Samples of one of the two passes: of odd numbers, the first has more.
static inline uint32_t rsv_uneven_half(uint32_t count, int half)
{
    return (count + 1 - (uint32_t)half) / 2;
}

/// Adds such passes, as above.
rsv_status rsv_sample_sum_add_uneven(
    rsv_context *context, rsv_sample_sum *sum, const rsv_uneven_pair *uneven, rsv_image *pass[2]);

/// Squared error of the mean of two halves, relative to the square of their difference D. Halves of one stratified
/// picture err in opposite ways, so that D^2 / 4 is up to twice the squared error at edges. Counting on that, where errors
/// decrease with the power p of n samples, by D^2 / 4 (n - 1) / (n^p - 1), left 1.2 and 1.3 times the squared error
/// requested in the modern hall and in `gallery`: in much of a picture, p is 1.
#define RSV_ERROR_OF_HALVES 0.25

/// Part of a sample's variance that is left in a pixel's mean after a pair of passes. The earlier samples do not judge
/// the later ones: a pixel without sparks among a few samples would seem to have none among many.
/// @param more samples of both @param renewed without those before
double rsv_variance_left(const rsv_summed_pixel *pixel, double more, bool renewed, double fall);

/// Maximum weight of a pixel in the noise of pictures with equally many samples in all: sparks weigh as much as edges of
/// a bright window, since more samples everywhere are no remedy.
#define RSV_MOST_OF_A_PIXEL 4

/// Squared errors decrease with this power of the samples. With stratified pixels, edges decrease with 1.5 and noise of
/// lights with 1. Gather rays have only noise: with 1.2, the white room had 52 samples instead of 79, and twice the
/// requested error.
#define RSV_STRATIFIED_FALL 1.2
#define RSV_GATHERED_FALL 1.0

/// Filters the picture, if passes have guides, to find the error that is left at each pixel. All noise is that of the
/// filtered picture from then on. Call it again after each pass. Needs two passes, and makes the number of samples each
/// pixel's own. @param fall of errors
rsv_status rsv_sample_sum_filter(rsv_context *context, rsv_sample_sum *sum, double fall);

/// The picture: filtered, if passes have guides and there are two of them.
/// @param image out: of the passes' layers, guides left out
rsv_status rsv_sample_sum_finish(rsv_context *context, rsv_sample_sum *sum, rsv_image **image);

/// Relative MSE by noise of the samples there are, equally many in all pixels. Needs two passes.
double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall);

/// Number of samples at which the relative MSE due to noise is lower by a factor. @param excess present MSE / target
uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most);

void rsv_sample_sum_clear(rsv_context *context, rsv_sample_sum *sum);

#endif
