/// Flux that photons left on elements, and the irradiance it amounts to.
#ifndef RSV_PHOTON_MAP_H
#define RSV_PHOTON_MAP_H

#include "../elements/elements.h"

/// Flux received by the nodes of one set of elements. Fixed-point sums, so that the order in which
/// threads add does not matter.
typedef struct rsv_photon_map {
    rsv_context *context;
    const rsv_elements *elements;
    int64_t (*flux)[3]; ///< [node_count] units of `unit`
    uint64_t *hits;     ///< [node_count] hat-weighted number of photons, 1 / 65536
    double unit;        ///< W
} rsv_photon_map;

/// @param unit W: the smallest flux that is told from none
rsv_status rsv_photon_map_create(
    rsv_context *context, const rsv_elements *elements, double unit, rsv_photon_map *map);

/// Adds the flux of one photon at (u, v) of a triangle's front or back; several threads may.
void rsv_photon_map_deposit(
    rsv_photon_map *map, bool back, uint32_t triangle, float u, float v, rsv_rgb flux);

/// Adds up what the processes of a team have caught. Before rsv_photon_map_settle.
void rsv_photon_map_unite(rsv_photon_map *map);

/// Hanging nodes own no area: gives what landed on them to their parents. Once, after the last photon.
void rsv_photon_map_settle(rsv_photon_map *map);

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
