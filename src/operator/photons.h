/// Caustics: light paths shot from the sources through at least one specular event to the first diffuse
/// interface (paths D S+ L), the adjoint of gathering.
#ifndef RSV_PHOTONS_H
#define RSV_PHOTONS_H

#include "photon_map.h"
#include "transport.h"

/// Whether the scene has anything that could cast a caustic, lit by a source that is not gathered.
bool rsv_photons_wanted(const rsv_transport_scene *scene, const rsv_lights *lights);

/// Shoots `count` light paths, guided towards directions in which each source sees specular surfaces, and
/// deposits them on `map_count` sets of elements at once. Unbiased: the guide never excludes a direction.
/// @param maps out; to be destroyed by the caller
rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_elements *const *elements, rsv_photon_map *maps,
    size_t map_count, uint64_t *rays);

#endif
