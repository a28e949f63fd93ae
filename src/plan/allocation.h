/// More camera rays where a picture is noisier.
///
/// A pixel with the relative squared error e of one sample, which decreases as their number^-p, gets a number of rays
/// proportional to e^(1 / (1 + p)). This minimises the mean error for a given mean number. The errors are those of the
/// pixel's neighbours, so that its mean does not depend on its number of samples and stays unbiased.
///
/// Sparks are the exception: pixels that a rare bright sample has made several times as bright as those around them.
/// They get rays by their own error too, which replace the samples that they had. What is rarely found is lost in part,
/// but even a small part of a spark is more error than that.
#ifndef RSV_ALLOCATION_H
#define RSV_ALLOCATION_H

#include "sample_sum.h"

typedef struct rsv_allocation {
    uint32_t *extra; ///< [height * width] further camera rays
    float *renewed;  ///< [height * width] as in rsv_uneven_pair
    double mean;     ///< of these rays, per pixel
    double noise;    ///< relative MSE by noise that is left with them
    double fall;
} rsv_allocation;

/// Allocates the further rays that bring noise down to an error, within a limit.
/// @param sum   at least two passes; its numbers of samples become each pixel's own
/// @param fall  p: RSV_STRATIFIED_FALL or RSV_GATHERED_FALL
/// @param error target relative MSE due to noise; 0 = as low as possible
/// @param most  limit of further camera rays per pixel, on average
rsv_status rsv_allocate_samples(rsv_context *context, rsv_sample_sum *sum, double fall,
    double error, double most, rsv_allocation *allocation);
void rsv_allocation_clear(rsv_context *context, rsv_allocation *allocation);

/// Relative MSE by noise of a sum whose numbers of samples are each pixel's own.
double rsv_uneven_noise(const rsv_sample_sum *sum);

#endif
