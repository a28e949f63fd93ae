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

/// @param unit W: the smallest flux that counts
rsv_status rsv_photon_map_create(
    rsv_context *context, const rsv_elements *elements, double unit, rsv_photon_map *map);
/// As if nothing had landed.
void rsv_photon_map_clear(rsv_photon_map *map);

/// Sums of whole numbers come out the same in any order.
RSV_INLINE void rsv_add_atomically(int64_t *sum, int64_t amount)
{
#if defined(__CUDA_ARCH__)
    atomicAdd((unsigned long long *)sum, (unsigned long long)amount);
#else
    __atomic_fetch_add(sum, amount, __ATOMIC_RELAXED);
#endif
}

RSV_INLINE void rsv_add_fixed(int64_t *sum, double value)
{
    rsv_add_atomically(sum, (int64_t)llrint(value));
}

/// Adds the flux of one photon at (u, v) of a triangle's front or back; several threads may.
RSV_INLINE void rsv_photon_map_deposit(
    const rsv_photon_map *map, bool back, uint32_t triangle, float u, float v, rsv_rgb flux)
{
    const rsv_elements *e = map->elements;
    uint32_t face = e->face_of[back][triangle];
    if (face == RSV_NONE) return;
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, face, u, v, weight);
    for (int k = 0; k < 3; k++) {
        uint32_t node = e->cell_node[cell][k];
        double scale = weight[k] / map->unit;
        rsv_add_fixed(&map->flux[node][0], flux.r * scale);
        rsv_add_fixed(&map->flux[node][1], flux.g * scale);
        rsv_add_fixed(&map->flux[node][2], flux.b * scale);
        int64_t share = (int64_t)(weight[k] * 65536.0f);
        rsv_add_atomically((int64_t *)&map->hits[node], share);
    }
}

/// Adds up the photons of a team's processes. Call it before rsv_photon_map_settle.
void rsv_photon_map_unite(rsv_photon_map *map);

/// Moves the photons of hanging nodes, which have no area, to their parents. Call it once, after the last photon.
void rsv_photon_map_settle(rsv_photon_map *map);

void rsv_photon_map_destroy(rsv_photon_map *map);

/// Irradiance at the nodes: flux over the area of the hat function. @param irradiance [node_count]
void rsv_photon_map_irradiance(const rsv_photon_map *map, rsv_rgb *irradiance);

/// Blends nodes with few photons towards a coarser estimate, by n / (n + RSV_PHOTON_PRIOR), with n the number of
/// photons caught, or that expected if it is larger. Keeps the total flux.
/// @param coarse irradiance on the elements of `coarse_map`
rsv_status rsv_photon_map_shrink(const rsv_photon_map *map, const rsv_photon_map *coarse_map,
    const rsv_rgb *coarse, rsv_rgb *irradiance);

#define RSV_PHOTON_PRIOR 8.0f

#endif
