/// The leading eigenvalue of a nonnegative map A: its spectral radius (Perron and Frobenius).
#ifndef RSV_LEADING_H
#define RSV_LEADING_H

#include "linear_map.h"

/// The result, the largest of the channels.
typedef struct rsv_leading_value {
    double value;    ///< <x, A x> of the last vector x of length 1
    double residual; ///< |A x - value x|
    uint32_t applications;
} rsv_leading_value;

/// Arnoldi's method from the field of ones, restarted from the leading Ritz vector after every few steps. Where A is
/// self-adjoint in the inner product, this is Lanczos's method: the value lies below the eigenvalue, by at most the
/// square of the residual over the distance to the next one.
/// @param weight [count x 3] of the inner product, >= 0, above 0 where A has a column; NULL = all 1
/// @param tolerance ends it: residual over value, in each channel @param max_steps applications at most
rsv_status rsv_leading_eigenvalue(const rsv_linear_map *map, const float *weight, double tolerance,
    uint32_t max_steps, rsv_leading_value *leading);

#endif
