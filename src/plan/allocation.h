/// More camera rays where a picture is noisier.
///
/// A pixel whose relative squared error is e after m samples, and falls as their number^-p, gets a number proportional to
/// e^(1 / (1 + p)): that makes the mean error least for a given mean number. The errors are those of the pixel's neighbours,
/// so that its mean knows nothing of the number of its samples and stays unbiased.
#ifndef RSV_ALLOCATION_H
#define RSV_ALLOCATION_H

#include "sample_sum.h"

typedef struct rsv_allocation {
    uint32_t *extra; ///< [height * width] further camera rays
    double mean;     ///< of these, per pixel
    double noise;    ///< relative MSE by noise that is left with them
} rsv_allocation;

/// As many further rays as bring the noise down to an error, or as are allowed.
/// @param sum   two passes at least
/// @param fall  p: RSV_STRATIFIED_FALL or RSV_GATHERED_FALL
/// @param error relative MSE by noise that is wanted; 0 = as low as possible
/// @param most  further camera rays per pixel, on average
rsv_status rsv_allocate_samples(rsv_context *context, const rsv_sample_sum *sum, double fall,
    double error, double most, rsv_allocation *allocation);
void rsv_allocation_clear(rsv_context *context, rsv_allocation *allocation);

#endif
