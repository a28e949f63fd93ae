/// Bases for download: halves, as differences between successive receivers and between channels, deflated. Neighbours
/// are similar, and so are the channels of light, so that a tenth of the bytes suffices.
#ifndef RSV_BAKE_BASIS_PACK_H
#define RSV_BAKE_BASIS_PACK_H

#include "../core/core.h"

/// One light of a basis, packed (docs/bake-reference.md).
typedef struct rsv_packed_light {
    uint8_t *bytes; ///< freed through the context
    size_t count;
    float scale; ///< a power of two that halves are multiplied by
} rsv_packed_light;

/// @param value [receivers][width], finite
rsv_status rsv_bake_pack_light(rsv_context *context, const float *value, size_t receivers,
    size_t width, rsv_packed_light *packed);

#endif
