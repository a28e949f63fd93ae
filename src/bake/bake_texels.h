/// From charts to texels: which place of the scene each texel shows.
#ifndef RSV_BAKE_TEXELS_H
#define RSV_BAKE_TEXELS_H

#include "bake_chart.h"
#include "bake_receiver.h"

typedef struct rsv_bake_map {
    uint32_t width, height;
    rsv_bake_receiver *receiver; ///< [height * width]
    float *
        distance; ///< [height * width] texels from the chart; INFINITY = empty, filled from others
    uint32_t *owner;   ///< [height * width] triangle of rsv_bake_charts around it
    uint32_t *repeats; ///< [height * width] of texels that show nothing: whose light they repeat
    rsv_rgb *light;    ///< [height * width]
} rsv_bake_map;

/// Texels along the sides of a map, and those of charts beyond their borders.
typedef struct rsv_bake_extent {
    uint32_t width, height, padding;
} rsv_bake_extent;

/// Finds the nearest place of a chart for every texel that filtering can reach: texels within surfaces, and those up to
/// `padding` beyond their borders, which continue light linearly.
/// @param overlap [charts->triangle_count] out: set for triangles that lie upon others of their chart; or NULL
rsv_status rsv_bake_map_create(const rsv_bake_charts *charts, const rsv_bake_part *parts,
    rsv_bake_extent extent, rsv_bake_map *map, uint8_t *overlap);
void rsv_bake_map_destroy(rsv_context *context, rsv_bake_map *map);

/// Light of all texels as elements store it: in time that is next to nothing, with shadows as coarse as elements.
void rsv_bake_map_light(const rsv_light_view *solution, rsv_bake_map *map);

/// The upper left one of the four texels around a place in texels, and the place between them, 0..1.
void rsv_bake_map_locate(
    const rsv_bake_map *map, const float point[2], uint32_t at[2], float part[2]);

/// Bilinear lookup at a place in texels.
rsv_rgb rsv_bake_map_lookup(const rsv_bake_map *map, const float point[2]);

/// Sum of the luminance of the texels that surfaces show.
double rsv_bake_map_sum(const rsv_bake_map *map);

/// Share of the texels that surfaces show.
double rsv_bake_map_coverage(const rsv_bake_map *map);

#endif
