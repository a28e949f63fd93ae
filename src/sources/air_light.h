/// Next-event estimation in the air: light of sampled sources that comes straight to a place in fog, and what of it the fog
/// scatters on, or a voxel receives.
#ifndef RSV_AIR_LIGHT_H
#define RSV_AIR_LIGHT_H

#include "../trace/ray.h"
#include "fog_lights.h"

/// Who asks. Borrowed.
typedef struct rsv_air_setting {
    const rsv_fog_lights *lights;
    const rsv_tracer *tracer;
    const rsv_fog *fog;
} rsv_air_setting;

/// A place in the fog.
typedef struct rsv_air_receiver {
    rsv_vec3 point;
    rsv_vec3
        forward; ///< unit direction of the ray that came here, against which light is scattered; zero = to all sides alike
    bool uneven; ///< by the uneven part of the phase function alone (phase.h)
    rsv_vec3 near; ///< middle of a sphere whose point and spot lights are left out
    float radius;  ///< of that, metres; 0 = none is
} rsv_air_receiver;

/// How much more than in the mean light from a direction is scattered along the ray that gathers it: 4 pi times the phase
/// function.
float rsv_air_response(const rsv_fog *fog, const rsv_air_receiver *receiver, rsv_vec3 towards);

/// Whether a punctual light is left out.
RSV_INLINE bool rsv_air_leaves_out(const rsv_air_receiver *r, const rsv_punctual_light *light)
{
    float extent = rsv_punctual_is_extended(light) ? 0.5f * v3_length(light->opening) : 0;
    return r->radius > 0 && !rsv_punctual_is_distant(light) &&
           v3_length(v3_sub(light->position, r->near)) < r->radius + extent;
}

/// Mean radiance of what arrives, weighed by the phase function, times 4 pi: fluence, where that is isotropic. One sample of
/// emitters, suns and sky, and all punctual lights or a few.
/// @param u numbers in [0, 1) for the choice of an emitter and the place on it, and for the sky @param rays are added to
rsv_rgb rsv_air_light(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    const float u[5], uint64_t *rays);

/// The same of the light behind one entry of rsv_fog_lights. @param u for the place on an emitter
rsv_rgb rsv_air_light_of_entry(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    uint32_t entry, const float u[2], uint64_t *rays);

/// Suns, sky and lights without a place: nothing but the receiver's place can find them.
rsv_rgb rsv_air_light_from_afar(const rsv_air_setting *setting, const rsv_air_receiver *receiver,
    const float u[2], uint64_t *rays);

/// Share of light that comes to a point in the air along a shadow ray, by what is in the way and by the fog.
rsv_rgb rsv_air_passed(const rsv_air_setting *setting, const rsv_ray *shadow, rsv_vec3 point,
    rsv_vec3 towards, float distance);

#endif
