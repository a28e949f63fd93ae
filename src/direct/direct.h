/// E0 by next-event estimation: irradiance that arrives at elements straight from the sources.
#ifndef RSV_DIRECT_H
#define RSV_DIRECT_H

#include "../elements/elements.h"
#include "../sources/lights.h"
#include "../specular/specular_path.h"

/// Irradiance at the free nodes from all sources that are not gathered, averaged over receiver points on
/// each node's support.
///
/// Each point's unshadowed irradiance is known in closed form (Lambert's formula) but for the weak ones of many emitters,
/// so only visibility is sampled: E = E_unshadowed * (sum f V / p) / (sum f / p). Fully lit and fully shadowed nodes come out
/// without noise; in penumbrae the ratio's bias is of order 1 / samples and far below its noise.
///
/// @param points per node, 4 or 16
/// @param samples shadow rays per node to emitters, a multiple of 16; punctual lights get one per point. Less than 16: a
///                preview from four points, and 16 rays where these see not the same
/// @param valid_points [node_count] from rsv_find_buried with the same points and seed
/// @param known [node_count] non-zero = the irradiance of this node stands already; NULL = none
/// @param deviation [node_count] estimated standard deviation of the luminance of each estimate; NULL = not
///                  wanted
rsv_status rsv_direct_irradiance(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *elements, uint32_t points, uint32_t samples, uint32_t seed,
    const uint16_t *valid_points, const uint8_t *known, rsv_rgb *irradiance, float *deviation,
    uint64_t *rays);

#endif
