/// Charts: pieces of surfaces laid flat in a lightmap.
///
/// Triangles that meet at less than a crease, and whose normals stay close to that of the first, are projected along
/// their mean normal. Walls and floors thus become undistorted rectangles; curved surfaces are compressed by at most
/// 0.6. If a part's own second texture coordinates are valid, their islands are its charts.
#ifndef RSV_BAKE_CHART_H
#define RSV_BAKE_CHART_H

#include "bake_part.h"

typedef struct rsv_bake_chart {
    uint32_t part;
    uint32_t first, triangle_count; ///< in rsv_bake_charts.triangle
    float size[2];                  ///< metres
    float detail;                   ///< density of its texels over that of others
    // of the map, once packed
    uint32_t texels[2]; ///< whole ones, at least 2: borders lie in the middle of the first and last
    uint32_t at[2];     ///< the first of them
    uint32_t turns;     ///< quarter turns, 0..3
} rsv_bake_chart;

typedef struct rsv_bake_charts {
    rsv_context *context;
    rsv_bake_chart *chart;
    size_t count, capacity;
    uint32_t *triangle;    ///< of the part, chart after chart
    float (*corner)[3][2]; ///< [triangle_count] metres from the chart's own corner
    size_t triangle_count, triangle_capacity, corner_capacity;
} rsv_bake_charts;

/// Divides a part into charts.
/// @param layer [triangle_count of the part] only triangles of one layer lie in a chart; NULL = all are of one
rsv_status rsv_bake_add_charts(rsv_bake_charts *charts, const rsv_light_view *solution,
    const rsv_bake_part *part, uint32_t part_index, const uint8_t *layer);

/// Makes charts of a part's texture coordinates, all at one scale: one of each island, so that they stay apart in the
/// map however few texels their gutters had.
/// @param uv [vertex_count of the part] @param whole one of all islands together, as they lie
rsv_status rsv_bake_keep_charts(rsv_bake_charts *charts, const rsv_light_view *solution,
    const rsv_bake_part *part, uint32_t part_index, const float (*uv)[2], bool whole);

/// Area of a chart's triangles, m2 where they lie.
double rsv_bake_chart_area(const rsv_bake_charts *charts, const rsv_bake_chart *chart);

/// A number for an edge in space, the same for both directions.
uint64_t rsv_bake_edge_key(rsv_vec3 a, rsv_vec3 b);

void rsv_bake_charts_destroy(rsv_bake_charts *charts);

/// Position of a chart's triangle corner in the map, texels.
static inline void rsv_bake_chart_point(
    const rsv_bake_chart *chart, const float corner[2], float point[2])
{
    for (uint32_t axis = 0; axis < 2; axis++) {
        uint32_t own = chart->turns & 1 ? 1 - axis : axis;
        bool is_reversed = chart->turns == 2 || chart->turns == 2 * axis + 1;
        float spans = (float)(chart->texels[axis] - 1), size = chart->size[own];
        float along = is_reversed ? size - corner[own] : corner[own];
        point[axis] = (float)chart->at[axis] + 0.5f + (size > 0 ? along / size * spans : 0);
    }
}

#endif
