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

/// Decides between the two. Knows at once where the norm of A is below 1.
/// @param lasting NULL, or [count x 3] out: A^k 1, k = RSV_LOSSLESS_ORDERS unless `unique`: of an irradiance of 1
///                everywhere, what comes to each node after so many orders
rsv_status rsv_fredholm_alternative(
    const rsv_linear_map *map, rsv_alternative *alternative, float *lasting);

/// How far a source is from having no part along the solutions w >= 0 of the adjoint.
/// @param map knows its transposed @param source [count x 3]
/// @param compatibility out: <w, E0> / (|w| |E0|), the largest of the channels; 0 = the source is compatible
rsv_status rsv_fredholm_compatibility(
    const rsv_linear_map *map, const float *source, double *compatibility);

/// Which share of the light that arrives at a node is still under way after `orders` more bounces:
/// (A*)^orders area / area.
/// @param map knows its transposed @param area [count] of the nodes, m2
/// @param survival [count x 3]; 0 where a node has no area
rsv_status rsv_survival(
    const rsv_linear_map *map, const float *area, uint32_t orders, float *survival);

#endif
