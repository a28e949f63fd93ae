#include "bake_patch.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"

/// Triangles of a chart around a texel.
typedef struct candidates {
    uint32_t triangle[9]; ///< of the charts
    int count;
} candidates;

uint32_t rsv_bake_chart_of(const rsv_bake_charts *charts, uint32_t k)
{
    size_t low = 0, high = charts->count;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (charts->chart[middle].first <= k)
            low = middle;
        else
            high = middle;
    }
    return (uint32_t)low;
}

/// Corners of a triangle in the map, texels.
static void flat_corners(
    const rsv_bake_charts *charts, const rsv_bake_chart *chart, uint32_t k, float p[3][2])
{
    for (int v = 0; v < 3; v++)
        rsv_bake_chart_point(chart, charts->corner[k][v], p[v]);
}

/// Weights of a triangle's corners at a point. @return whether it lies within
static bool weigh(const float p[3][2], float x, float y, float w[3])
{
    float area =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
    bool within = area != 0;
    for (int k = 0; k < 3 && area != 0; k++) {
        const float *a = p[(k + 1) % 3], *b = p[(k + 2) % 3];
        w[k] = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        within = within && w[k] >= 0;
    }
    return within;
}

static candidates find_candidates(const rsv_bake_sheet *sheet, size_t texel, uint32_t chart)
{
    const rsv_bake_map *map = sheet->map;
    const rsv_bake_chart *own = &sheet->charts->chart[chart];
    candidates found = { { map->owner[texel] }, 1 };
    uint32_t x = (uint32_t)(texel % map->width), y = (uint32_t)(texel / map->width);
    for (uint32_t k = 0; k < 9; k++) {
        uint32_t nx = x + k % 3 - 1, ny = y + k / 3 - 1; // below 0: beyond the width
        if (nx >= map->width || ny >= map->height) continue;
        uint32_t owner = map->owner[(size_t)ny * map->width + nx];
        bool known =
            owner == RSV_NONE || owner < own->first || owner >= own->first + own->triangle_count;
        for (int n = 0; n < found.count && !known; n++)
            known = found.triangle[n] == owner;
        if (!known) found.triangle[found.count++] = owner;
    }
    return found;
}

/// The place at weights `w` of a triangle of the charts.
static rsv_surface_place place_at(
    const rsv_bake_sheet *sheet, const rsv_bake_chart *chart, uint32_t k, const float w[3])
{
    const rsv_bake_part *part = &sheet->parts[chart->part];
    uint32_t own = sheet->charts->triangle[k];
    rsv_surface_place place = { .triangle = part->triangle[own],
        .back = part->back[own],
        .width = 1 / (sheet->density * chart->detail) };
    rsv_bake_place(part, w[1], w[2], &place.u, &place.v);
    return place;
}

/// Weights of the corners of a texel's triangle at its place, slightly inside.
static void own_weights(const rsv_bake_sheet *sheet, size_t texel, float w[3])
{
    const rsv_bake_receiver *r = &sheet->map->receiver[texel];
    const rsv_bake_charts *charts = sheet->charts;
    uint32_t chart = rsv_bake_chart_of(charts, sheet->map->owner[texel]);
    rsv_bake_place(&sheet->parts[charts->chart[chart].part], r->u, r->v, &w[1], &w[2]);
    w[0] = 1 - w[1] - w[2];
    for (int k = 0; k < 3; k++)
        w[k] += PULL * (1.0f / 3 - w[k]);
}

void rsv_bake_texel_point(const rsv_bake_sheet *sheet, size_t texel, float point[2])
{
    float p[3][2], w[3];
    uint32_t owner = sheet->map->owner[texel], chart = rsv_bake_chart_of(sheet->charts, owner);
    flat_corners(sheet->charts, &sheet->charts->chart[chart], owner, p);
    own_weights(sheet, texel, w);
    for (int a = 0; a < 2; a++)
        point[a] = w[0] * p[0][a] + w[1] * p[1][a] + w[2] * p[2][a];
}

void rsv_bake_texel_patch(const rsv_bake_sheet *sheet, size_t texel, rsv_bake_patch *patch)
{
    const rsv_bake_charts *charts = sheet->charts;
    uint32_t owner = sheet->map->owner[texel];
    float middle[2], p[3][2], w[3];
    patch->count = 0;
    if (owner == RSV_NONE) return;
    uint32_t c = rsv_bake_chart_of(charts, owner);
    const rsv_bake_chart *chart = &charts->chart[c];
    const candidates around = find_candidates(sheet, texel, c);
    rsv_bake_texel_point(sheet, texel, middle);
    for (uint32_t k = 0; k < RSV_BAKE_PLACES; k++) {
        float x, y;
        rsv_sobol_2d(k, 0, &x, &y);
        x += middle[0] - 0.5f, y += middle[1] - 0.5f;
        for (int n = 0; n < around.count; n++) {
            flat_corners(charts, chart, around.triangle[n], p);
            if (!weigh((const float(*)[2])p, x, y, w)) continue;
            patch->place[patch->count++] = place_at(sheet, chart, around.triangle[n], w);
            break;
        }
    }
    if (patch->count > 0) return;
    own_weights(sheet, texel, w);
    patch->place[patch->count++] = place_at(sheet, chart, owner, w);
}
