/// Light at a place of a surface, gathered through the solution: what elements store is read at the far ends of rays alone, and
/// direct light is sampled there too. Takes hundreds of rays, but does not depend on how large the elements are that hold the place.
#ifndef RSV_BAKE_GATHER_H
#define RSV_BAKE_GATHER_H

#include "resolvent/render.h"

#include "../solve/light.h"

/// What arrives other than straight from the sources that shadow rays are sent to, W/m2. Not for translucent surfaces.
/// @param rays gather rays @param seed of their random numbers
rsv_rgb rsv_bake_gather(
    const rsv_light_view *light, const rsv_surface_place *place, uint32_t rays, uint32_t seed);

#endif
