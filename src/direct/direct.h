/// E0 by next-event estimation: irradiance that arrives at elements straight from the sources.
#ifndef RSV_DIRECT_H
#define RSV_DIRECT_H

#include "direct_receiver.h"

/// Irradiance at the free nodes from all sources that are not gathered, averaged over receiver points on
/// each node's support.
///
/// Each point's unshadowed irradiance is known in closed form (Lambert's formula) but for the weak ones of many emitters,
/// so only visibility is sampled: E = E_unshadowed * (sum f V / p) / (sum f / p). Fully lit and fully shadowed nodes come out
/// without noise; in penumbrae the ratio's bias is of order 1 / samples and far below its noise.
///
/// @param job its lights may be some of those of the scene
/// @param known [node_count] non-zero = the irradiance of this node stands already; NULL = none
/// @param light out, [node_count]; rays are added
rsv_status rsv_direct_irradiance(
    const rsv_direct_job *job, const uint8_t *known, rsv_direct_light *light);

#endif
