/// Caustics: light paths shot from the sources through at least one specular event to the first diffuse
/// interface (paths D S+ L), the adjoint of gathering.
#ifndef RSV_PHOTONS_H
#define RSV_PHOTONS_H

#include "transport.h"

/// Flux received by the nodes of one set of elements. Fixed-point sums, so that the order in which
/// threads add does not matter.
typedef struct rsv_photon_map {
    rsv_context *context;
    const rsv_elements *elements;
    int64_t (*flux)[3]; ///< [node_count] units of `unit`
    uint64_t *hits;     ///< [node_count] hat-weighted number of photons, 1 / 65536
    double unit;        ///< W
} rsv_photon_map;

/// Whether the scene has anything that could cast a caustic, lit by a source that is not gathered.
bool rsv_photons_wanted(const rsv_transport_scene *scene, const rsv_lights *lights);

/// Shoots `count` light paths, guided towards directions in which each source sees specular surfaces, and
/// deposits them on `map_count` sets of elements at once. Unbiased: the guide never excludes a direction.
/// @param maps out; to be destroyed by the caller
rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_elements *const *elements, rsv_photon_map *maps,
    size_t map_count, uint64_t *rays);

void rsv_photon_map_destroy(rsv_photon_map *map);

/// Irradiance at the nodes: flux over the area of the hat function. @param irradiance [node_count]
void rsv_photon_map_irradiance(const rsv_photon_map *map, rsv_rgb *irradiance);

/// Draws nodes for which few photons speak towards a coarser estimate, by n / (n + RSV_PHOTON_PRIOR) with n
/// the photons caught or, if that is more, those to be expected. The total flux stays what it was.
/// @param coarse irradiance on the elements of `coarse_map`
rsv_status rsv_photon_map_shrink(const rsv_photon_map *map, const rsv_photon_map *coarse_map,
    const rsv_rgb *coarse, rsv_rgb *irradiance);

#define RSV_PHOTON_PRIOR 8.0f

#endif
