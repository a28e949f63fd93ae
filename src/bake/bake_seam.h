/// What filtering shows where charts meet.
#ifndef RSV_BAKE_SEAM_H
#define RSV_BAKE_SEAM_H

#include "bake_texels.h"

/// Changes texels along borders of charts, mostly those beyond, until filtering shows the solved light on both sides, where
/// surface and light go on smoothly. Light jumps by itself at creases, and where a wall stands on the border: it may.
/// @param largest out: the largest jump left, relative to the light there
rsv_status rsv_bake_close_seams(const rsv_solution *solution, const rsv_bake_charts *charts,
    const rsv_bake_parts *parts, rsv_bake_map *map, double *largest);

#endif
