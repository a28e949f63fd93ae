/// Punctual lights close to a surface. Most of their light lands on an area smaller than the support of a node, between
/// its receiver points. The mean is therefore computed over parts that are small compared with their distance to the
/// light.
#ifndef RSV_NEAR_PUNCTUAL_H
#define RSV_NEAR_PUNCTUAL_H

#include "direct_receiver.h"

/// Which lights are close to a node, in front of it. None where a tree draws lights: there are too many then.
/// @return bit k = light k of rsv_punctual_at
uint32_t rsv_near_punctual(const rsv_direct_job *job, uint32_t node);

/// Adds the light of these lights: irradiance averaged with the node's hat function.
/// @param near_lights not 0
void rsv_near_punctual_add(const rsv_direct_job *job, const rsv_node_receivers *receivers,
    uint32_t node, uint32_t near_lights, rsv_direct_estimate *estimate);

#endif
