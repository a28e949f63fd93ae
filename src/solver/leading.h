/// The leading eigenvalue of a nonnegative map A: its spectral radius (Perron and Frobenius).
#ifndef RSV_LEADING_H
#define RSV_LEADING_H

#include "linear_map.h"

/// The result, the largest of the channels.
typedef struct rsv_leading_value {
    double value;    ///< of the last vector x of length 1
    double residual; ///< |A x - value x|
    uint32_t applications;
} rsv_leading_value;

/// Arnoldi's method from the field of ones, restarted from the leading Ritz vector after every few steps.
/// @param tolerance ends it: residual over value, in each channel @param max_steps applications at most
rsv_status rsv_leading_eigenvalue(
    const rsv_linear_map *map, double tolerance, uint32_t max_steps, rsv_leading_value *leading);

#endif
