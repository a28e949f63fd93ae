/// The part of a surface that one value of a file represents: the area of a texel, or that around a vertex.
#ifndef RSV_BAKE_PATCH_H
#define RSV_BAKE_PATCH_H

#include "bake_texels.h"
#include "resolvent/render.h"

#define RSV_BAKE_PLACES 16 ///< of a patch at most

/// Places spread evenly over a patch, of which the first few are spread evenly too.
typedef struct rsv_bake_patch {
    rsv_surface_place place[RSV_BAKE_PLACES];
    uint32_t count; ///< 0 = shows nothing
} rsv_bake_patch;

/// Charts of a map, and the parts that they are of.
typedef struct rsv_bake_sheet {
    const rsv_bake_charts *charts;
    const rsv_bake_part *parts;
    const rsv_bake_map *map;
    float density; ///< texels per metre
} rsv_bake_sheet;

/// The chart that a triangle of the charts is in.
uint32_t rsv_bake_chart_of(const rsv_bake_charts *charts, uint32_t k);

/// The point of its chart that a texel shows, in texels: its middle, or the nearest place on the chart's border.
void rsv_bake_texel_point(const rsv_bake_sheet *sheet, size_t texel, float point[2]);

/// The area of its chart that a texel covers or, if it is beyond the border, that of the nearest place on it.
void rsv_bake_texel_patch(const rsv_bake_sheet *sheet, size_t texel, rsv_bake_patch *patch);

#endif
