/// More camera rays where a picture is noisier.
///
/// A pixel with the relative squared error e after m samples, which decreases as their number^-p, gets a number of rays
/// proportional to e^(1 / (1 + p)). This minimises the mean error for a given mean number. The errors are those of the
/// pixel's neighbours, so that its mean does not depend on its number of samples and stays unbiased.
#ifndef RSV_ALLOCATION_H
#define RSV_ALLOCATION_H

#include "sample_sum.h"

typedef struct rsv_allocation {
    uint32_t *extra; ///< [height * width] further camera rays
    double mean;     ///< of these, per pixel
    double noise;    ///< relative MSE by noise that is left with them
} rsv_allocation;

/// Allocates the further rays that bring noise down to an error, within a limit.
/// @param sum   at least two passes
/// @param fall  p: RSV_STRATIFIED_FALL or RSV_GATHERED_FALL
/// @param error target relative MSE due to noise; 0 = as low as possible
/// @param most  limit of further camera rays per pixel, on average
rsv_status rsv_allocate_samples(rsv_context *context, const rsv_sample_sum *sum, double fall,
    double error, double most, rsv_allocation *allocation);
void rsv_allocation_clear(rsv_context *context, rsv_allocation *allocation);

#endif
