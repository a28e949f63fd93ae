/// E0 by next-event estimation: irradiance that arrives at elements straight from the sources.
#ifndef RSV_DIRECT_H
#define RSV_DIRECT_H

#include "direct_receiver.h"

/// Irradiance at the free nodes from all sources that are not gathered, averaged over receiver points on each node's
/// support.
///
/// The unshadowed irradiance of each point is known in closed form (Lambert's formula), except for the weak ones of
/// many emitters. Only visibility is sampled: E = E_unshadowed * (sum f V / p) / (sum f / p). Fully lit and fully
/// shadowed nodes have no noise. In penumbrae, the bias of the ratio is of order 1 / samples, far below its noise.
///
/// @param job its lights may be a subset of the scene's
/// @param known [node_count] non-zero = the irradiance of this node is known; NULL = none is
/// @param light out, [node_count]; rays are added
rsv_status rsv_direct_irradiance(
    const rsv_direct_job *job, const uint8_t *known, rsv_direct_light *light);

#endif
