/// The best mixture of unfiltered and filtered light, pixel by pixel.
#ifndef RSV_DENOISE_MIXTURE_H
#define RSV_DENOISE_MIXTURE_H

#include "window.h"

#define MIXTURE_PLANES (2 * (1 + RSV_MEAN_KINDS))

/// @param planes [MIXTURE_PLANES] borrowed
/// @param least square of light that counts as none
/// @param mixed  out: planes of three channels
void rsv_mix_by_errors(const rsv_plane_grid *grid, const rsv_light_planes *light,
    const rsv_filtered_planes *filtered, float least, float *planes, float *mixed[3]);

#endif
