/// Seams: differences that filtering shows where charts meet.
#ifndef RSV_BAKE_SEAM_H
#define RSV_BAKE_SEAM_H

#include "bake_layout.h"

/// Changes texels along borders of charts, mostly those beyond, until filtering shows the solved light on both sides,
/// where surface and light are continuous. Light may jump at creases, and where a wall stands on the border.
/// @param mean of the light: in darker places, jumps are relative to a fraction of it
/// @param map that of the layout, lit by the solution
/// @param open [layout->charts.count] out: set for charts with remaining visible jumps; or NULL
/// @param largest out: the largest remaining jump, relative to the light there
rsv_status rsv_bake_close_seams(const rsv_light_view *solution, const rsv_bake_layout *layout,
    double mean, rsv_bake_map *map, uint8_t *open, double *largest);

#endif
