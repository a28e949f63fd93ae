#include "bake_mask.h"

#include "../core/vec.h"

#include <string.h>

/// Whether the square around (x, y) lies beyond an edge, of which the triangle is to the left.
static bool is_beyond(const float a[2], const float b[2], float x, float y)
{
    float dx = b[0] - a[0], dy = b[1] - a[1];
    return dx * (y - a[1]) - dy * (x - a[0]) + 0.5f * (fabsf(dx) + fabsf(dy)) < 0;
}

static bool is_touched(const float *const corner[3], float x, float y)
{
    for (int k = 0; k < 3; k++)
        if (is_beyond(corner[k], corner[(k + 1) % 3], x, y)) return false;
    return true;
}

static void draw_triangle(rsv_bake_mask *mask, const uint32_t size[2], const float p[3][2])
{
    uint32_t begin[2], end[2];
    float twice_area =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
    const float *const corner[3] = { p[0], p[twice_area < 0 ? 2 : 1], p[twice_area < 0 ? 1 : 2] };
    for (int a = 0; a < 2; a++) {
        begin[a] = (uint32_t)f_max(f_min(p[0][a], f_min(p[1][a], p[2][a])), 0);
        end[a] = (uint32_t)f_max(p[0][a], f_max(p[1][a], p[2][a])) + 1;
        if (end[a] > size[a]) end[a] = size[a];
    }
    for (uint32_t y = begin[1]; y < end[1]; y++)
        for (uint32_t x = begin[0]; x < end[0]; x++)
            if (is_touched(corner, (float)x + 0.5f, (float)y + 0.5f))
                mask->touched[(size_t)y * size[0] + x] = 1;
}

static bool is_beside_touched(
    const rsv_bake_mask *mask, const uint32_t size[2], uint32_t x, uint32_t y)
{
    for (uint32_t v = y ? y - 1 : 0; v <= y + 1 && v < size[1]; v++)
        for (uint32_t u = x ? x - 1 : 0; u <= x + 1 && u < size[0]; u++)
            if (mask->touched[(size_t)v * size[0] + u]) return true;
    return false;
}

static bool is_whole(const rsv_bake_mask *mask, const uint32_t size[2])
{
    for (uint32_t y = 0; y < size[1]; y++)
        for (uint32_t x = 0; x < size[0]; x++)
            if (!mask->touched[(size_t)y * size[0] + x] && !is_beside_touched(mask, size, x, y))
                return false;
    return true;
}

static rsv_status list_runs(rsv_bake_mask *mask, const uint32_t size[2])
{
    rsv_status status = RSV_OK;
    mask->run_count = 0;
    for (uint32_t row = 0; row < size[1]; row++) {
        const uint8_t *touched = mask->touched + (size_t)row * size[0];
        for (uint32_t x = 0; x < size[0]; x++) {
            if (!touched[x]) continue;
            uint32_t begin = x;
            while (x < size[0] && touched[x])
                x++;
            RSV_TRY(rsv_grow(mask->context, (void **)&mask->run, &mask->run_capacity,
                mask->run_count + 1, sizeof *mask->run));
            mask->run[mask->run_count++] = (rsv_bake_run){ row, begin, x };
        }
    }
cleanup:
    return status;
}

rsv_status rsv_bake_mask_draw(
    rsv_bake_mask *mask, const rsv_bake_charts *charts, const rsv_bake_chart *chart)
{
    size_t texels = (size_t)chart->texels[0] * chart->texels[1];
    rsv_status status =
        rsv_grow(mask->context, (void **)&mask->touched, &mask->touched_capacity, texels, 1);
    if (status != RSV_OK) return status;
    memset(mask->touched, 0, texels);
    rsv_bake_chart alone = *chart;
    alone.at[0] = alone.at[1] = 0;
    for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++) {
        float point[3][2];
        for (int v = 0; v < 3; v++)
            rsv_bake_chart_point(&alone, charts->corner[k][v], point[v]);
        draw_triangle(mask, chart->texels, (const float(*)[2])point);
    }
    mask->is_whole = is_whole(mask, chart->texels);
    if (mask->is_whole) memset(mask->touched, 1, texels);
    return list_runs(mask, chart->texels);
}

void rsv_bake_mask_destroy(rsv_bake_mask *mask)
{
    rsv_free(mask->context, mask->run);
    rsv_free(mask->context, mask->touched);
    *mask = (rsv_bake_mask){ .context = mask->context };
}
