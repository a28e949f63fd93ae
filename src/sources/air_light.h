/// Next-event estimation in the air: light of sampled sources that arrives straight at a point in fog, and the part
/// that the fog scatters or a voxel receives.
#ifndef RSV_AIR_LIGHT_H
#define RSV_AIR_LIGHT_H

#include "../trace/ray.h"
#include "fog_lights.h"

/// Scene and lights. Borrowed.
typedef struct rsv_air_setting {
    const rsv_fog_lights *lights;
    const rsv_tracer *tracer;
    const rsv_fog *fog;
} rsv_air_setting;

/// A point in the fog.
typedef struct rsv_air_receiver {
    rsv_vec3 point;
    rsv_vec3
        forward; ///< unit direction of the ray that arrived here and gathers light; zero = isotropic
    bool uneven; ///< use only the directional part of the phase function (phase.h)
    rsv_vec3 near; ///< centre of a sphere whose point and spot lights are omitted
    float radius;  ///< of the sphere, metres; 0 = omit none
} rsv_air_receiver;

/// Scattering from a direction along the gathering ray, relative to isotropic scattering: 4 pi times the phase
/// function.
float rsv_air_response(const rsv_fog *fog, const rsv_air_receiver *receiver, rsv_vec3 towards);

/// Whether a punctual light is omitted.
RSV_INLINE bool rsv_air_leaves_out(const rsv_air_receiver *r, const rsv_punctual_light *light)
{
    float extent = rsv_punctual_is_extended(light) ? 0.5f * v3_length(light->opening) : 0;
    return r->radius > 0 && !rsv_punctual_is_distant(light) &&
           v3_length(v3_sub(light->position, r->near)) < r->radius + extent;
}

/// Mean incoming radiance, weighted by the phase function, times 4 pi; fluence, if that is isotropic. Uses one sample
/// of emitters, suns and sky, and all punctual lights or a few.
/// @param u numbers in [0, 1) for the choice of an emitter and the point on it, and for the sky
/// @param rays incremented by the number of rays
rsv_rgb rsv_air_light(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    const float u[5], uint64_t *rays);

/// The same for the light of one entry of rsv_fog_lights. @param u for the point on an emitter
rsv_rgb rsv_air_light_of_entry(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    uint32_t entry, const float u[2], uint64_t *rays);

/// Suns, sky and directional lights, which can only be sampled from the receiver.
rsv_rgb rsv_air_light_from_afar(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    const float u[2], uint64_t *rays);

/// Transmittance of a shadow ray to a point in the air: surfaces in the way, and the fog.
rsv_rgb rsv_air_passed(const rsv_air_setting *setting, const rsv_ray *shadow, rsv_vec3 point,
    rsv_vec3 towards, float distance);

#endif
