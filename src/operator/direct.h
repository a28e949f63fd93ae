/// E0 by next-event estimation: irradiance that arrives at elements straight from the sources.
#ifndef RSV_DIRECT_H
#define RSV_DIRECT_H

#include "transport.h"

/// Irradiance at the free nodes from all sources that are not gathered, averaged over receiver points on
/// each node's support.
///
/// Each point's unshadowed irradiance is known in closed form (Lambert's formula), so only visibility is
/// sampled: E = E_unshadowed * (sum f V / p) / (sum f / p). Fully lit and fully shadowed nodes come out
/// without noise; in penumbrae the ratio's bias is of order 1 / samples and far below its noise.
///
/// @param points per node, 4 or 16
/// @param samples shadow rays per node to emitters, a multiple of 16; punctual lights get one per point
/// @param valid_points [node_count] bit k: receiver point k is not buried; NULL = find out with a few
///                     rays. Must come from the same seed and 16 points.
/// @param known [node_count] non-zero = irradiance and validity of this node stand already; NULL = none
/// @param node_valid [node_count], out: some receiver point is not buried
rsv_status rsv_direct_irradiance(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *elements, uint32_t points, uint32_t samples, uint32_t seed,
    const uint16_t *valid_points, const uint8_t *known, rsv_rgb *irradiance, uint8_t *node_valid,
    uint64_t *rays);

/// Gives nodes without a valid receiver point the mean of their valid neighbours, so that interpolation
/// next to something that stands on a surface does not fade to black.
void rsv_fill_buried(const rsv_elements *elements, const uint8_t *node_valid, rsv_rgb *value);

#endif
