/// Mean of independent samples and how well it is known.
#ifndef RSV_MOMENTS_H
#define RSV_MOMENTS_H

#include "../core/core.h"

typedef struct rsv_moments {
    double mean;
    double ci95[2]; ///< confidence interval of the mean
} rsv_moments;

/// The interval is Student's, moved by Johnson's correction for skew samples (Johnson 1978, "Modified t tests and
/// confidence intervals for asymmetrical populations"): mean squares have a long upper tail, and the plain
/// interval would end too low.
rsv_moments rsv_moments_of(const double *sample, size_t count);

/// Mean by weights, a ratio of two sums: its interval is that of the ratio in the first order. Weights of 1 change nothing.
/// @param sample overwritten
rsv_moments rsv_moments_by_weight(double *sample, const double *weight, size_t count);

/// With another independent variance of the mean. @param count of the samples
rsv_moments rsv_moments_with(rsv_moments moments, size_t count, double variance);

/// Square roots. Where chance has made an estimate too small, negative even, it is the mean of what it may be: of the
/// normal distribution around it, as far as that is above 0. Of a number that is known well it is the root.
rsv_moments rsv_moments_root(rsv_moments squares);

#endif
