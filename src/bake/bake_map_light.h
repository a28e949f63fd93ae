/// Light of a map's texels, each estimated from the surface that it covers.
#ifndef RSV_BAKE_MAP_LIGHT_H
#define RSV_BAKE_MAP_LIGHT_H

#include "bake_grid_light.h"

/// @param light out: [height * width of the map], those that show nothing too: they continue the light of charts
rsv_status rsv_bake_light_map(const rsv_light_view *solution, const rsv_bake_sheet *sheet,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light);

#endif
