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

/// Mean by weights, a ratio of two sums: its interval is that of the ratio in the first order. Weights of 1 change
/// nothing.
/// @param sample overwritten
rsv_moments rsv_moments_by_weight(double *sample, const double *weight, size_t count);

/// With another independent variance of the mean. @param count of the samples
rsv_moments rsv_moments_with(rsv_moments moments, size_t count, double variance);

/// Square roots. An estimate that is too small by chance, or even negative, is replaced by the mean of the positive
/// part of the normal distribution around it. If the number is known well, this is the root.
rsv_moments rsv_moments_root(rsv_moments squares);

#endif
