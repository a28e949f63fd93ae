/// What rough surfaces on the way of a camera ray reflect of the gathered sky, as far as rows of G tell where it is seen:
/// it is aimed at and met by chance, and the two are weighed by the power heuristic.
#ifndef RSV_ROUGH_AIM_H
#define RSV_ROUGH_AIM_H

#include "rough_light.h"
#include "sky_aim.h"

/// Where the surface aims at the gathered sky; nowhere if none is known to be seen.
/// @param visibility NULL = none is
void rsv_rough_aim(
    const rsv_rough_surface *surface, const rsv_sky_visibility *visibility, rsv_sky_aim *aim);

/// Radiance that the surface scatters towards the camera from the gathered sky. @param u in [0, 1)
rsv_rgb rsv_rough_aimed_light(const rsv_rough_surface *surface, const rsv_lights *lights,
    const rsv_sky_aim *aim, const float u[3]);

#endif
