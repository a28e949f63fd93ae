/// What guides a filter of a picture (../denoise): layers of an image behind the picture itself.
#ifndef RSV_PICTURE_GUIDES_H
#define RSV_PICTURE_GUIDES_H

#include "../core/vec.h"
#include "resolvent/render.h"

/// Layers, from 1 on. Like the picture, they are means over a pixel's camera rays.
typedef enum rsv_picture_guide {
    RSV_GUIDE_DIFFUSE, ///< part of the picture that the first surfaces reflect diffusely
    RSV_GUIDE_ALBEDO,  ///< radiance of that part for an irradiance of pi
    RSV_GUIDE_NORMAL,  ///< of the first surface, with its normal map; 0 = there is none
    RSV_GUIDE_PLACE,   ///< r: 1 / distance, 0 = no surface
    RSV_PICTURE_GUIDES
} rsv_picture_guide;

/// Whether a picture has guides.
static inline bool rsv_has_guides(const rsv_image *image)
{
    return rsv_image_find_layer(image, "albedo") == 1 + (uint32_t)RSV_GUIDE_ALBEDO;
}

/// A guide of a picture that has them.
static inline const rsv_rgb *rsv_guide_of(const rsv_image *image, rsv_picture_guide guide)
{
    return rsv_image_const_pixels(image, 1 + (uint32_t)guide);
}

#endif
