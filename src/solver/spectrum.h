/// How fast the orders of light die out: the spectral radius of a nonnegative map A.
#ifndef RSV_SPECTRUM_H
#define RSV_SPECTRUM_H

#include "linear_map.h"

/// Bounds of the spectral radius.
///
/// `lower` and `upper` are those of Collatz (1942) and Wielandt (1950): the smallest and the largest (A x)_i / x_i over
/// the nodes where x is positive. For any nonnegative x, the smallest is a bound; the largest is one for x = A^k 1, whose
/// zeros belong to zero rows of A^k. `power` is ||A^k||_inf^(1/k), which is ||A^k 1||_inf^(1/k)
/// for a nonnegative A, and never below the spectral radius (Gelfand). All hold up to rounding of floats.
typedef struct rsv_spectral_radius {
    double lower, upper; ///< largest of the channels' bounds
    double power;        ///< upper bound
    double norm;         ///< ||A||_inf
    double resolvent;    ///< ||(I - A)^-1||_inf is at most this; INFINITY = no bound was found
    double size[3];      ///< ||A^k 1||_inf by channel after the last application
    uint32_t applications;
} rsv_spectral_radius;

typedef struct rsv_power_desc {
    uint32_t max_steps;
    double gap;   ///< stop when upper - lower is below this
    double doubt; ///< stop when `power` is below this, because more is not needed; 0 = continue

    bool transposed; ///< of A*; `norm`, `power` and `resolvent` are then NAN
} rsv_power_desc;

/// Power iteration on A from the field of ones.
/// @param vector [count x 3] the last iterate, of max norm 1 in each channel; 0 where A is nilpotent
rsv_status rsv_power_iteration(const rsv_linear_map *map, const rsv_power_desc *desc, float *vector,
    rsv_spectral_radius *radius);

/// Terms of a Neumann series until one is below `target`: the first is `size`, each `radius` times the one before.
uint32_t rsv_neumann_terms(double radius, double size, double target);

#endif
