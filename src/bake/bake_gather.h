/// Light at a place of a surface, gathered through the solution: stored light is only read at the far ends of rays, and
/// direct light is sampled there too. Takes hundreds of rays, but does not depend on the size of the elements at the
/// place.
#ifndef RSV_BAKE_GATHER_H
#define RSV_BAKE_GATHER_H

#include "resolvent/render.h"

#include "../solve/light.h"

/// Light other than directly from the sources of shadow rays, W/m2. Not for translucent surfaces.
/// @param rays gather rays @param seed of their random numbers
rsv_rgb rsv_bake_gather(
    const rsv_light_view *light, const rsv_surface_place *place, uint32_t rays, uint32_t seed);

#endif
