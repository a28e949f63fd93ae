/// What kinds of punctual lights there are, as facts that the rest of the library goes by: a new kind is described here, and
/// what it sends where in sources/punctual_light.h. For device code too.
#ifndef RSV_PUNCTUAL_H
#define RSV_PUNCTUAL_H

#include "../core/vec.h"
#include "resolvent/scene.h"

#define RSV_LIGHT_KINDS (RSV_PUNCTUAL_DIRECTIONAL + 1)

/// Infinitely far away: its intensity is an irradiance, and it has no place.
RSV_INLINE bool rsv_punctual_is_distant(const rsv_punctual_light *light)
{
    return light->kind == RSV_PUNCTUAL_DIRECTIONAL;
}

/// Sends light into a cone around its direction alone.
RSV_INLINE bool rsv_punctual_has_cone(const rsv_punctual_light *light)
{
    return light->kind == RSV_PUNCTUAL_SPOT;
}

#endif
