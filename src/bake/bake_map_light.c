#include "bake_map_light.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_filter.h"
#include "bake_smooth.h"

/// What few shadow rays of a texel found.
typedef struct pilot {
    float open, seen, choice; ///< of rsv_bake_estimate
    float light;              ///< luminance of all
} pilot;

typedef struct map_light {
    const rsv_light_view *s;
    const rsv_bake_sheet *sheet;
    const rsv_bake_map_desc *desc;
    size_t texels;
    uint32_t *chart;  ///< [texels] that each is of; RSV_NONE = none
    pilot *pilot;     ///< [texels]
    rsv_rgb *half[2]; ///< [texels] of what is sampled
    rsv_rgb *light;   ///< [texels] of the rest
} map_light;

static void keep(map_light *q, size_t texel, const rsv_bake_estimate *e)
{
    q->light[texel] = rgb_add(e->stored, e->punctual);
    q->half[0][texel] = e->half[0];
    q->half[1][texel] = e->half[1];
}

// ---- shadow rays ----------------------------------------------------------------------------------

static void take_pilots(map_light *q)
{
    const rsv_bake_map *map = q->sheet->map;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(q->s->context))
    for (size_t k = 0; k < q->texels; k++) {
        rsv_bake_patch patch;
        q->chart[k] = RSV_NONE;
        if (map->owner[k] == RSV_NONE || rsv_cancelled(q->s->context)) continue;
        q->chart[k] = rsv_bake_chart_of(q->sheet->charts, map->owner[k]);
        rsv_bake_texel_patch(q->sheet, k, &patch);
        rsv_bake_estimate e = rsv_bake_estimate_patch(
            q->s, &patch, PILOT_SAMPLES, rsv_hash3(q->desc->seed, (uint32_t)k, 0));
        keep(q, k, &e);
        q->pilot[k] =
            (pilot){ e.open, e.seen, e.choice, rgb_luminance(rsv_bake_estimate_total(&e)) };
    }
}

/// Means over a texel and its neighbours on the chart: one that asked itself alone would stop where its few rays happen to
/// agree.
static pilot look_around(const map_light *q, size_t texel)
{
    const rsv_bake_map *map = q->sheet->map;
    long x = (long)(texel % map->width), y = (long)(texel / map->width);
    pilot mean = { 0, 0, 0, 0 };
    float count = 0;
    for (long b = y - PILOT_REACH; b <= y + PILOT_REACH; b++)
        for (long a = x - PILOT_REACH; a <= x + PILOT_REACH; a++) {
            if (a < 0 || b < 0 || a >= (long)map->width || b >= (long)map->height) continue;
            size_t n = (size_t)b * map->width + (size_t)a;
            if (q->chart[n] != q->chart[texel]) continue;
            const pilot *p = &q->pilot[n];
            mean.open += p->open;
            mean.seen += p->open * p->seen;
            mean.choice += p->choice;
            mean.light += p->light;
            count++;
        }
    mean.seen = mean.open > 0 ? mean.seen / mean.open : 0;
    mean.open /= count;
    mean.choice /= count;
    mean.light /= count;
    return mean;
}

/// Shadow rays of each half that the wanted error takes; 0 = what is there will do.
static uint32_t wanted_samples(const map_light *q, size_t texel)
{
    pilot p = look_around(q, texel);
    float by_shadow = STRATIFIED * p.open * p.open * f_max(p.seen * (1 - p.seen), 0);
    float variance = by_shadow + STRATIFIED * p.choice;
    if (!(variance > 0)) return 0;
    float deviation = FILTER_GAIN * q->desc->error * f_max(p.light, q->desc->dark);
    float samples = 0.5f * variance / (deviation * deviation);
    return (uint32_t)f_min(f_max(samples, LEAST_SAMPLES), MOST_LIGHT_SAMPLES);
}

static rsv_status send_rays(map_light *q)
{
    rsv_context *context = q->s->context;
    size_t done = 0;
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context))
    for (size_t k = 0; k < q->texels; k++) {
        if (rsv_thread_index() == 0 && (++done & 1023) == 0)
            rsv_progress(context, "bake",
                f_min((float)(done * (size_t)rsv_threads(context)) / (float)q->texels, 1));
        if (q->chart[k] == RSV_NONE || rsv_cancelled(context)) continue;
        uint32_t samples = wanted_samples(q, k);
        if (samples == 0) continue;
        rsv_bake_patch patch;
        rsv_bake_texel_patch(q->sheet, k, &patch);
        // other numbers than the pilot's, which chose how many
        rsv_bake_estimate e = rsv_bake_estimate_patch(
            q->s, &patch, samples, rsv_hash3(q->desc->seed, (uint32_t)k, 1));
        keep(q, k, &e);
    }
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

// ---- beyond borders -------------------------------------------------------------------------------

/// Share of the change from `back` to `on` that a texel beyond a border goes on by: it stays near to what is on the border.
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

/// All that is beyond charts: some of it continues them, the rest repeats what is next to it.
static void fill(const map_light *q, rsv_rgb *light)
{
    const rsv_bake_map *map = q->sheet->map;
#pragma omp parallel for schedule(dynamic, 1024) num_threads(rsv_threads(q->s->context))
    for (size_t k = 0; k < q->texels; k++)
        if (q->chart[k] != RSV_NONE)
            light[k] =
                map->distance[k] > 0 && map->receiver[k].beyond > 0 ? extend(q, k) : q->light[k];
    for (size_t k = 0; k < q->texels; k++)
        if (q->chart[k] == RSV_NONE)
            light[k] = map->repeats[k] == RSV_NONE ? rgb_gray(0) : light[map->repeats[k]];
}

static rsv_status estimate(map_light *q, rsv_rgb *light)
{
    rsv_status status;
    rsv_bake_smooth smooth;
    RSV_TRY(rsv_bake_smooth_create(q->s, &smooth));
    q->s = &smooth.view;
    take_pilots(q);
    RSV_TRY(send_rays(q));
    if (rsv_lights_any_sampled(q->s->lights)) {
        const rsv_bake_map *map = q->sheet->map;
        const rsv_bake_noisy_map noisy = { map->width, map->height, q->chart,
            { q->half[0], q->half[1] } };
        RSV_TRY(rsv_bake_filter(q->s->context, &noisy));
    }
    for (size_t k = 0; k < q->texels; k++)
        q->light[k] =
            rgb_positive(rgb_mad(q->light[k], 0.5f, rgb_add(q->half[0][k], q->half[1][k])));
    fill(q, light);
cleanup:
    rsv_bake_smooth_destroy(&smooth);
    return status;
}

rsv_status rsv_bake_light_map(const rsv_light_view *s, const rsv_bake_sheet *sheet,
    const rsv_bake_map_desc *desc, rsv_rgb *light)
{
    rsv_context *context = s->context;
    rsv_status status = RSV_ERROR_MEMORY;
    map_light q = { .s = s,
        .sheet = sheet,
        .desc = desc,
        .texels = (size_t)sheet->map->width * sheet->map->height };
    q.chart = rsv_alloc(context, q.texels, sizeof *q.chart);
    q.pilot = rsv_alloc(context, q.texels, sizeof *q.pilot);
    q.light = rsv_alloc(context, q.texels, sizeof *q.light);
    for (int h = 0; h < 2; h++)
        q.half[h] = rsv_alloc(context, q.texels, sizeof *q.half[h]);
    if (q.chart && q.pilot && q.light && q.half[0] && q.half[1]) status = estimate(&q, light);
    rsv_free(context, q.chart);
    rsv_free(context, q.pilot);
    rsv_free(context, q.light);
    rsv_free(context, q.half[0]);
    rsv_free(context, q.half[1]);
    return status;
}
