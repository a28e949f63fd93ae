/// Noise of a map taken out by means over neighbours that show the same light: non-local means by known variances, each
/// of two independent halves weighed by the other, so that noise does not choose its own neighbours (Rousselle et al.,
/// "Adaptive rendering with non-local means filtering", 2012). Edges of shadows stay: neighbours beyond them differ by
/// more than noise.
#ifndef RSV_BAKE_FILTER_H
#define RSV_BAKE_FILTER_H

#include "../core/core.h"
#include "resolvent/scene.h"

typedef struct rsv_bake_noisy_map {
    uint32_t width, height;
    const uint32_t *group; ///< [height * width] only texels of one group are mixed; RSV_NONE = none
    const rsv_rgb *half[2]; ///< [height * width] noisy
    rsv_rgb *filtered[2];   ///< [height * width] out
} rsv_bake_noisy_map;

/// RSV_ERROR_MEMORY, or RSV_ERROR_CANCELLED.
rsv_status rsv_bake_filter(rsv_context *context, const rsv_bake_noisy_map *map);

#endif
