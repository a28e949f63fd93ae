/// Properties of the kinds of punctual lights, which all code uses. A new kind is described here, and its emission in
/// sources/punctual_light.h. Also for device code.
#ifndef RSV_PUNCTUAL_H
#define RSV_PUNCTUAL_H

#include "../core/vec.h"
#include "resolvent/scene.h"

RSV_INLINE rsv_punctual_facts rsv_punctual_kind(rsv_punctual_light_kind kind)
{
    // name, place, direction, cone
    const rsv_punctual_facts point = { "point", true, false, false },
                             spot = { "spot", true, true, true },
                             directional = { "directional", false, true, false },
                             luminaire = { "luminaire", true, true, true },
                             unknown = { NULL, false, false, false };
    return kind == RSV_PUNCTUAL_POINT         ? point
           : kind == RSV_PUNCTUAL_SPOT        ? spot
           : kind == RSV_PUNCTUAL_DIRECTIONAL ? directional
           : kind == RSV_PUNCTUAL_LUMINAIRE   ? luminaire
                                              : unknown;
}

/// Infinitely far away: its intensity is an irradiance, and it has no place.
RSV_INLINE bool rsv_punctual_is_distant(const rsv_punctual_light *light)
{
    return !rsv_punctual_kind(light->kind).has_place;
}

RSV_INLINE bool rsv_punctual_has_direction(const rsv_punctual_light *light)
{
    return rsv_punctual_kind(light->kind).has_direction;
}

/// Has a size: each ray goes to a place of its own (sources/punctual_light.h).
RSV_INLINE bool rsv_punctual_is_extended(const rsv_punctual_light *light)
{
    return light->kind == RSV_PUNCTUAL_LUMINAIRE &&
           (light->opening.x != 0 || light->opening.y != 0 || light->opening.z != 0);
}

/// Half of its extent.
RSV_INLINE float rsv_punctual_radius(const rsv_punctual_light *light)
{
    return rsv_punctual_is_extended(light) ? 0.5f * v3_length(light->opening) : 0;
}

/// Whether it emits only into a cone around its direction.
RSV_INLINE bool rsv_punctual_has_cone(const rsv_punctual_light *light)
{
    return rsv_punctual_kind(light->kind).has_cone;
}

#endif
