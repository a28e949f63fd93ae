/// The Fredholm alternative: either E = E0 + G K E has one solution for every E0, or E = G K E has solutions of its
/// own, and then E0 must have no part along the solutions w of the adjoint w = (G K)* w.
#ifndef RSV_FREDHOLM_H
#define RSV_FREDHOLM_H

#include "spectrum.h"

/// A spectral radius from here on is 1 to the precision of the operator.
#define RSV_LOSSLESS 0.9999

typedef struct rsv_alternative {
    bool unique; ///< every source has one solution
    rsv_spectral_radius radius;
} rsv_alternative;

/// Orders after which light that has not begun to die out never will.
#define RSV_LOSSLESS_ORDERS 64

/// Decides between the two. Immediate if the norm of A is below 1.
/// @param lasting NULL, or [count x 3] out: A^k 1, k = RSV_LOSSLESS_ORDERS, unless `unique`: for an irradiance of 1
/// everywhere,
///                the light that arrives at each node after that many orders
rsv_status rsv_fredholm_alternative(
    const rsv_linear_map *map, rsv_alternative *alternative, float *lasting);

/// How compatible a source is with the solutions w >= 0 of the adjoint equation.
/// @param map with a transposed map @param source [count x 3]
/// @param compatibility out: <w, E0> / (|w| |E0|), the largest of the channels; 0 = the source is compatible
rsv_status rsv_fredholm_compatibility(
    const rsv_linear_map *map, const float *source, double *compatibility);

/// The fraction of the light arriving at a node that is left after `orders` more bounces: (A*)^orders area / area.
/// @param map with a transposed map @param area [count] of the nodes, m2
/// @param survival [count x 3]; 0 where a node has no area
rsv_status rsv_survival(
    const rsv_linear_map *map, const float *area, uint32_t orders, float *survival);

#endif
