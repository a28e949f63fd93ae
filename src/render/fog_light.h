/// Light that fog scatters: at a place where a gather ray ends, and along a segment of a camera path.
#ifndef RSV_FOG_LIGHT_H
#define RSV_FOG_LIGHT_H

#include "../solve/light.h"

/// Fluence that comes straight from sampled sources to a place in the fog: one sample of each. That of lights close by
/// is averaged over the voxel.
rsv_rgb rsv_fog_fluence_sample(const rsv_light_view *light, rsv_vec3 place, rsv_random *random);

/// Radiance of light straight from sampled sources that is scattered isotropically at a point in the fog, where a
/// gather ray ends (specular/fog_flight.h).
rsv_rgb rsv_fog_scattered_sample(const rsv_light_view *light, rsv_vec3 place, rsv_random *random);

/// Radiance that the fog emits at a point, and scatters of stored light.
/// @param skip_sampled without the light that next-event estimation finds
rsv_rgb rsv_fog_stored_radiance(const rsv_light_view *light, rsv_vec3 place, bool skip_sampled);

/// Radiance that a gather ray finds where it ends in fog: sampled light of sampled sources, and stored light for the
/// rest.
rsv_rgb rsv_fog_radiance_at(const rsv_light_view *light, rsv_vec3 place, rsv_random *random);

/// Takes light of one order: 0 = emitted, n = scattered n times since, the last one by the fog.
typedef void (*rsv_fog_sink)(void *user, uint32_t order, rsv_rgb radiance);

/// Takes a point in the fog where indirect light is to be gathered.
/// @param weight radiance towards the start of the segment, per radiance averaged over all directions around the point
typedef void (*rsv_fog_gather)(void *user, rsv_vec3 place, rsv_rgb weight, rsv_random *random);

/// A segment of a camera path.
typedef struct rsv_fog_segment {
    rsv_ray ray;        ///< of unit direction
    rsv_rgb throughput; ///< of the path up to it
    float u[8];         ///< numbers in [0, 1) for sampling, in pairs
    uint32_t seed;      ///< for further ones
    bool final;         ///< light scattered once is sampled; else it is looked up
    bool by_order; ///< stored light is passed on order by order; otherwise all of it as order 2
    rsv_fog_gather
        gather; ///< gets one sampled point, in place of the stored indirect light; NULL = look it up
} rsv_fog_segment;

/// Passes on the light that the fog scatters and emits along a segment towards its start. Voxels are integrated in
/// closed form.
/// @param user of sink and of segment->gather
/// @return transmittance of the segment
rsv_rgb rsv_fog_march(
    const rsv_light_view *light, const rsv_fog_segment *segment, rsv_fog_sink sink, void *user);

#endif
