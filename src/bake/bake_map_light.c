#include "bake_map_light.h"

#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_smooth.h"

typedef struct map_light {
    const rsv_bake_sheet *sheet;
    size_t texels;
    uint32_t *chart; ///< [texels] that each is of; RSV_NONE = none
    rsv_rgb *light;  ///< [texels] on charts and their borders
} map_light;

// ---- beyond borders -------------------------------------------------------------------------------

/// Limits the extrapolation beyond a border from the change between `back` and `on`, so that texels stay close to the
/// border's value.
static float limit(float beyond, rsv_rgb on, rsv_rgb back)
{
    float change = f_max(fabsf(on.r - back.r), f_max(fabsf(on.g - back.g), fabsf(on.b - back.b)));
    float most = MOST_BEYOND * f_min(on.r, f_min(on.g, on.b));
    if (change * beyond <= most) return beyond;
    return change > 0 ? most / change : 0;
}

/// Light of a texel beyond its chart, from that on the border and that of the texel as far inside.
static rsv_rgb extend(const map_light *q, size_t texel)
{
    const rsv_bake_map *map = q->sheet->map;
    float on[2];
    rsv_bake_texel_point(q->sheet, texel, on);
    float x = (float)(texel % map->width) + 0.5f, y = (float)(texel / map->width) + 0.5f;
    long bx = (long)(2 * on[0] - x), by = (long)(2 * on[1] - y);
    if (bx < 0 || by < 0 || bx >= (long)map->width || by >= (long)map->height)
        return q->light[texel];
    size_t back = (size_t)by * map->width + (size_t)bx;
    float way = hypotf((float)bx + 0.5f - on[0], (float)by + 0.5f - on[1]);
    if (q->chart[back] != q->chart[texel] || map->distance[back] > 0 || !(way > 0))
        return q->light[texel];
    float beyond = limit(hypotf(x - on[0], y - on[1]) / way, q->light[texel], q->light[back]);
    return rgb_positive(rgb_mad(q->light[texel], beyond, rgb_sub(q->light[texel], q->light[back])));
}

/// Fills texels beyond charts: some extrapolate the charts, the rest repeat their neighbours.
static void fill(const map_light *q, rsv_rgb *light)
{
    const rsv_bake_map *map = q->sheet->map;
    for (size_t k = 0; k < q->texels; k++)
        if (q->chart[k] != RSV_NONE)
            light[k] =
                map->distance[k] > 0 && map->receiver[k].beyond > 0 ? extend(q, k) : q->light[k];
    for (size_t k = 0; k < q->texels; k++)
        if (q->chart[k] == RSV_NONE)
            light[k] = map->repeats[k] == RSV_NONE ? rgb_gray(0) : light[map->repeats[k]];
}

static void find_charts(const map_light *q)
{
    const rsv_bake_map *map = q->sheet->map;
    for (size_t k = 0; k < q->texels; k++)
        q->chart[k] = map->owner[k] == RSV_NONE
                          ? RSV_NONE
                          : rsv_bake_chart_of(q->sheet->charts, map->owner[k]);
}

static uint32_t texel_patch(const void *user, size_t texel, rsv_bake_patch *patch)
{
    rsv_bake_texel_patch(user, texel, patch);
    return (uint32_t)texel;
}

rsv_status rsv_bake_light_map(const rsv_light_view *s, const rsv_bake_sheet *sheet,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light)
{
    rsv_status status;
    const rsv_bake_map *map = sheet->map;
    rsv_bake_smooth smooth;
    map_light q = { .sheet = sheet, .texels = (size_t)map->width * map->height };
    RSV_TRY(rsv_bake_smooth_create(s, &smooth));
    q.chart = rsv_alloc(s->context, q.texels, sizeof *q.chart);
    q.light = rsv_alloc(s->context, q.texels, sizeof *q.light);
    RSV_TRY(q.chart && q.light ? RSV_OK : RSV_ERROR_MEMORY);
    find_charts(&q);
    const rsv_bake_grid grid = { map->width, map->height, q.chart, PILOT_SAMPLES, sheet,
        texel_patch };
    RSV_TRY(rsv_bake_light_grid(&smooth.view, &grid, accuracy, q.light, NULL));
    fill(&q, light);
cleanup:
    rsv_bake_smooth_destroy(&smooth);
    rsv_free(s->context, q.chart);
    rsv_free(s->context, q.light);
    return status;
}
