/// Gather paths that collect light of sources on rough surfaces on their way. No row of G contains this light; it is
/// for receivers on which no photon lands.
#ifndef RSV_LIT_GATHER_H
#define RSV_LIT_GATHER_H

#include "../sources/lights.h"
#include "../specular/specular_path.h"

/// Data common to such paths; borrowed.
typedef struct rsv_lit_setting {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    bool
        shot; ///< omit the light of photons: emitters that are not gathered, suns and punctual lights
} rsv_lit_setting;

/// Follows a specular path from its first surface to its diffuse end, drawing events by their probability. Emission of
/// gathered groups counts wherever it is hit, that of other sources behind specular surfaces: smooth surfaces lead
/// there by chance, and from rough ones sources are sampled too (rough_light.h).
/// @return emission: light found of sources, the sky included. For an escaped path, it is all of the light.
rsv_gather rsv_gather_lit(
    const rsv_lit_setting *setting, rsv_specular_path path, rsv_random *random);

/// The same along a ray. @param medium that it starts in; NULL = the air
rsv_gather rsv_gather_lit_ray(const rsv_lit_setting *setting, const rsv_medium *medium,
    const rsv_ray *ray, rsv_random *random);

#endif
