/// Light of a map's texels, each estimated from the surface that it covers (bake_direct.h).
///
/// Few shadow rays at first; more where those of a texel and its neighbours do not agree, as many as the wanted error takes;
/// then noise that is left is filtered out (bake_filter.h).
#ifndef RSV_BAKE_MAP_LIGHT_H
#define RSV_BAKE_MAP_LIGHT_H

#include "bake_direct.h"

typedef struct rsv_bake_map_desc {
    float error; ///< wanted of the median texel, relative
    float dark;  ///< W/m2 beside which errors are measured
    uint32_t seed;
} rsv_bake_map_desc;

/// @param light out: [height * width of the map], those that show nothing too: they continue the light of charts
rsv_status rsv_bake_light_map(const rsv_light_view *solution, const rsv_bake_sheet *sheet,
    const rsv_bake_map_desc *desc, rsv_rgb *light);

#endif
