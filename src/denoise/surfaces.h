/// Surfaces that a picture shows, for the weights of its windows.
#ifndef RSV_DENOISE_SURFACES_H
#define RSV_DENOISE_SURFACES_H

#include "planes.h"

/// The surfaces; all [plane].
typedef struct rsv_surface_planes {
    float *normal[3];
    float *normal_variance; ///< of the mean of both halves
    float *place;           ///< 1 / distance, which is affine on planes; far below 0 in margins
    float *slope[2];        ///< of place along x and y
    float *place_scale;     ///< 1 / square of the deviation from the plane that counts as 1
} rsv_surface_planes;

#define SURFACE_PLANES 8

/// @param planes [SURFACE_PLANES] borrowed
void rsv_find_surfaces(const rsv_plane_grid *grid, const rsv_denoise_half half[2], float *planes,
    rsv_surface_planes *surfaces);

#endif
