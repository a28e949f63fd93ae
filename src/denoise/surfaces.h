/// Surfaces that a picture shows, for the weights of its windows.
#ifndef RSV_DENOISE_SURFACES_H
#define RSV_DENOISE_SURFACES_H

#include "planes.h"

#define SURFACE_PLANES 8

/// @param planes [SURFACE_PLANES] borrowed
void rsv_find_surfaces(const rsv_plane_grid *grid, const rsv_denoise_half half[2], float *planes,
    rsv_surface_planes *surfaces);

#endif
