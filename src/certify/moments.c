#include "moments.h"

#include <math.h>

#define NORMAL95 1.959963985 ///< half of a 95 % interval, in deviations
/// Estimates that lie farther below 0 than that are taken to lie there.
#define LEAST_DEVIATIONS 8.0

/// Two-sided 95 % point of Student's distribution, to 1e-3 from 15 degrees of freedom on (Cornish and Fisher).
static double student95(double freedom)
{
    static const double z = NORMAL95;
    return z + (z * z * z + z) / (4 * freedom) +
           (5 * pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * freedom * freedom);
}

rsv_moments rsv_moments_of(const double *sample, size_t count)
{
    double sum = 0, squares = 0, cubes = 0, n = (double)count;
    if (count < 2) return (rsv_moments){ count ? sample[0] : 0, { 0, 0 } };
    for (size_t k = 0; k < count; k++)
        sum += sample[k];
    double mean = sum / n;
    for (size_t k = 0; k < count; k++) {
        double d = sample[k] - mean;
        squares += d * d;
        cubes += d * d * d;
    }
    double variance = squares / (n - 1), t = student95(n - 1);
    double half = t * sqrt(variance / n);
    // skewness x deviation = cubes / n / variance
    double shift = variance > 0 ? (1 + 2 * t * t) * cubes / (6 * n * n * variance) : 0;
    return (rsv_moments){ mean, { mean + shift - half, mean + shift + half } };
}

rsv_moments rsv_moments_by_weight(double *sample, const double *weight, size_t count)
{
    double sum = 0, weights = 0;
    for (size_t k = 0; k < count; k++) {
        sum += weight[k] * sample[k];
        weights += weight[k];
    }
    double mean = weights > 0 ? sum / weights : 0;
    for (size_t k = 0; k < count && weights > 0; k++)
        sample[k] = mean + weight[k] * (sample[k] - mean) * (double)count / weights;
    return rsv_moments_of(sample, count);
}

rsv_moments rsv_moments_with(rsv_moments m, size_t count, double variance)
{
    double t = student95((double)count - 1), half = (m.ci95[1] - m.ci95[0]) / 2;
    double wider = sqrt(half * half + t * t * variance) - half;
    return (rsv_moments){ m.mean, { m.ci95[0] - wider, m.ci95[1] + wider } };
}

/// Mean of a number that cannot be negative: of the positive part of a normal distribution.
static double positive_mean(double mean, double deviation)
{
    if (!(deviation > 0)) return fmax(mean, 0);
    double z = fmax(mean / deviation, -LEAST_DEVIATIONS);
    double density = exp(-0.5 * z * z) / sqrt(2 * M_PI), above = 0.5 * erfc(-z / M_SQRT2);
    return fmax(deviation * (z + density / above), 0);
}

rsv_moments rsv_moments_root(rsv_moments squares)
{
    double deviation = (squares.ci95[1] - squares.ci95[0]) / (2 * NORMAL95);
    double mean = positive_mean(squares.mean, deviation);
    double above = fmax(squares.ci95[1] - squares.mean, 0);
    double low = fmin(squares.ci95[0], squares.mean), high = fmax(squares.mean, 0) + above;
    return (rsv_moments){ sqrt(mean), { sqrt(fmax(low, 0)), sqrt(fmax(high, mean)) } };
}
