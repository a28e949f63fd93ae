/// Where a source of photons sees what is worth hitting: a distribution over the unit square from which the
/// directions of its rays come.
#ifndef RSV_PHOTON_GUIDE_H
#define RSV_PHOTON_GUIDE_H

#include "../core/core_internal.h"

#define RSV_GUIDE_SIDE 64 ///< bins along each side of the square
#define RSV_GUIDE_RAYS 4  ///< pilot rays per bin

typedef struct rsv_photon_guide {
    float useful;    ///< share of pilot rays that were worth their while
    float *row_cdf;  ///< [RSV_GUIDE_SIDE]
    float *cell_cdf; ///< [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE], per row
    float *density;  ///< [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE] over the square; nowhere 0
} rsv_photon_guide;

/// @param useful [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE] how many of a bin's pilot rays were useful
rsv_status rsv_photon_guide_create(
    rsv_context *context, const float *useful, rsv_photon_guide *guide);
void rsv_photon_guide_destroy(rsv_context *context, rsv_photon_guide *guide);

/// Warps a uniform point of the unit square by the guide, neighbours to neighbours, so that points of a
/// quasi-random set stay spread out. @return the density there
float rsv_photon_guide_warp(const rsv_photon_guide *guide, float *x, float *y);

#endif
