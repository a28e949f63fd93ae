/// A filter for noisy pictures, steered by the noise that is known to be in them.
///
/// A picture comes as two halves with independent noise. Where the halves differ, there is noise; what exceeds it is
/// detail, and stays. Each pixel becomes a mean of the pixels around it, weighted by how probable it is that both show
/// the same light (non-local means: Buades et al. 2005, for rendering Rousselle et al. 2012 and 2013):
///
/// - Light reflected diffusely by first surfaces is filtered without their albedo, so textures stay sharp. All other
///   light is filtered by itself.
/// - Weights come from the surfaces (normal, distance) and from the light of one half, and are applied to the other, so
///   that noise does not select itself.
#ifndef RSV_DENOISE_H
#define RSV_DENOISE_H

#include "resolvent/core.h"

/// One of two halves of a picture; all [height * width], borrowed.
typedef struct rsv_denoise_half {
    const rsv_rgb *picture;
    const rsv_rgb *diffuse; ///< the part of it that first surfaces reflect diffusely
    const rsv_rgb *albedo;  ///< factor of that part
    const rsv_rgb *normal;  ///< of the first surface
    const rsv_rgb *place;   ///< r: 1 / distance of the first surface, 0 = none
} rsv_denoise_half;

/// Filters two halves with equally much noise. Their mean is the picture, their difference shows what noise is left.
/// @param filtered out, [height * width] each; slightly negative where a pixel is dark beside bright ones
rsv_status rsv_denoise(rsv_context *context, uint32_t width, uint32_t height,
    const rsv_denoise_half half[2], rsv_rgb *const filtered[2]);

#endif
