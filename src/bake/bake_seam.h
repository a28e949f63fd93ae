/// What filtering shows where charts meet.
#ifndef RSV_BAKE_SEAM_H
#define RSV_BAKE_SEAM_H

#include "bake_layout.h"

/// Changes texels along borders of charts, mostly those beyond, until filtering shows the solved light on both sides, where
/// surface and light go on smoothly. Light jumps by itself at creases, and where a wall stands on the border: it may.
/// @param mean of the light: jumps where there is far less of it are seen against a share of that
/// @param map that of the layout, lit by the solution
/// @param open [layout->charts.count] out: set for charts along which jumps stay that are seen; or NULL
/// @param largest out: the largest jump left, relative to the light there
rsv_status rsv_bake_close_seams(const rsv_light_view *solution, const rsv_bake_layout *layout,
    double mean, rsv_bake_map *map, uint8_t *open, double *largest);

#endif
