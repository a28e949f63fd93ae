/// Shares of each source's light that arrive, stored per node of elements: what highlights are multiplied with where no ray is
/// worth its while. One byte per node and source.
#ifndef RSV_SHADOW_SHARES_H
#define RSV_SHADOW_SHARES_H

#include "../elements/elements.h"
#include "highlight.h"

typedef struct rsv_shadow_shares {
    rsv_context *context;
    uint32_t source_count; ///< of the highlights
    size_t node_count;
    uint8_t *share; ///< [node_count * source_count] 0..254 = share of 254; 255 = not known
} rsv_shadow_shares;

/// Traces `rays` rays from each node to each source. @param elements those of direct light, the finest at hand
rsv_status rsv_shadow_shares_create(const rsv_highlights *highlights, const rsv_tracer *tracer,
    const rsv_elements *elements, uint32_t rays, uint32_t seed, rsv_shadow_shares **shares);
void rsv_shadow_shares_destroy(rsv_shadow_shares *shares);

/// The share of a source about a point of a cell, interpolated between its nodes.
/// @param node, weight [3] of the cell's corners
/// @param certain out: all corners agree that it is lit or dark; else it is a guess, and rays are worth it
/// @return negative = not known
float rsv_shadow_share_at(const rsv_shadow_shares *shares, const uint32_t node[3],
    const float weight[3], uint32_t source, bool *certain);

#endif
