/// Reflections of the gathered sky in rough surfaces on the way of a camera ray, where rows of G know its visibility:
/// the sky is sampled and hit by chance, combined by the power heuristic.
#ifndef RSV_ROUGH_AIM_H
#define RSV_ROUGH_AIM_H

#include "rough_light.h"
#include "sky_aim.h"

/// Samples the gathered sky from the surface, unless no part of it is known to be visible.
/// @param visibility NULL = unknown
void rsv_rough_aim(
    const rsv_rough_surface *surface, const rsv_sky_visibility *visibility, rsv_sky_aim *aim);

/// Radiance that the surface scatters towards the camera from the gathered sky. @param u in [0, 1)
rsv_rgb rsv_rough_aimed_light(const rsv_rough_surface *surface, const rsv_lights *lights,
    const rsv_sky_aim *aim, const float u[3]);

#endif
