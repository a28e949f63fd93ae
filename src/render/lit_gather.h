/// Gather specular paths that find, on their way over rough surfaces, what sources send there: light that no row of G holds, for
/// receivers that no photon lands on.
#ifndef RSV_LIT_GATHER_H
#define RSV_LIT_GATHER_H

#include "../sources/lights.h"
#include "../specular/specular_path.h"

/// What such paths have in common; borrowed.
typedef struct rsv_lit_setting {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    bool
        shot; ///< leaves out what photons bring: emitters that are not gathered, suns and punctual lights
} rsv_lit_setting;

/// Follows a specular path from its first surface to its diffuse end, drawing events by their probability. Emission of gathered
/// groups counts wherever it is met, that of other sources behind specular surfaces: smooth ones lead there by chance, from
/// rough ones sources are aimed at as well (rough_light.h).
/// @return emission: what was found of sources, the sky included. Of an escaped specular path it holds all there is.
rsv_gather rsv_gather_lit(
    const rsv_lit_setting *setting, rsv_specular_path path, rsv_random *random);

/// The same along a ray. @param medium that it starts in; NULL = the air
rsv_gather rsv_gather_lit_ray(const rsv_lit_setting *setting, const rsv_medium *medium,
    const rsv_ray *ray, rsv_random *random);

#endif
