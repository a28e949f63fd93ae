/// Making a lightmap show the same on both sides of a seam.
#ifndef RSV_BAKE_STITCH_H
#define RSV_BAKE_STITCH_H

#include "bake_texels.h"

/// A point on the borders of two charts: its solved light, and its positions in the map.
typedef struct rsv_bake_stitch {
    rsv_rgb solved;
    float point[2][2]; ///< texels
    uint32_t chart[2];
    float
        least; ///< light there, or that of dark places: jumps are relative to it or, if the map is brighter, to the map
} rsv_bake_stitch;

/// Jump that a map shows, relative to the light there.
double rsv_bake_jump(const rsv_bake_map *map, const rsv_bake_stitch *stitch);

/// Changes texels as little as possible, mostly those beyond borders, until filtering shows the solved light and then,
/// more strictly, the same light on both sides.
/// @param largest out: the largest remaining jump, relative to the light there
rsv_status rsv_bake_stitch_up(rsv_context *context, const rsv_bake_stitch *stitch, size_t count,
    rsv_bake_map *map, double *largest);

#endif
