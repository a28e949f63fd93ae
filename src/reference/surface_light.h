/// What enters surfaces, path traced: what elements are to hold.
#ifndef RSV_SURFACE_LIGHT_H
#define RSV_SURFACE_LIGHT_H

#include "resolvent/render.h"

/// A point of one side of a triangle.
typedef struct rsv_surface_place {
    uint32_t triangle;
    float u, v;
    bool back;
    float width; ///< edge of the patch that its normal map is averaged over
} rsv_surface_place;

/// The irradiance of surfaces by their normal maps, averaged over patches, without the light that their coats keep from what scatters
/// diffusely below.
/// @param samples, seed as in rsv_probe_reference @param readings [count]
rsv_status rsv_surface_light_reference(const rsv_scene *scene, const rsv_surface_place *places,
    size_t count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings);

#endif
