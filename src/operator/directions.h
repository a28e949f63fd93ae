/// Tables of stratified cosine-distributed directions for the rows of G.
#ifndef RSV_DIRECTIONS_H
#define RSV_DIRECTIONS_H

#include "../core/core.h"
#include "../core/sampling.h"

#define RSV_DIRECTION_SETS 64

/// `sets` independent randomisations of a (0, 2)-net mapped to the hemisphere about +z. Within a set,
/// every 16 consecutive directions lie in one cell of the net: rays of a packet run alongside each other.
typedef struct rsv_directions {
    rsv_context *context;
    uint32_t count;   ///< per set, a power of two >= 16
    float *x, *y, *z; ///< [RSV_DIRECTION_SETS * count]
} rsv_directions;

rsv_status rsv_directions_create(
    rsv_context *context, uint32_t count, uint32_t seed, rsv_directions *directions);
void rsv_directions_destroy(rsv_directions *directions);

/// Index of the first direction that a node uses.
RSV_INLINE size_t rsv_directions_of(const rsv_directions *directions, uint32_t seed, uint32_t node)
{
    return (size_t)(rsv_hash2(seed, node) % RSV_DIRECTION_SETS) * directions->count;
}

#endif
