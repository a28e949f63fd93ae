#include "bake_grid_light.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_filter.h"

/// What few shadow rays of a patch found.
typedef struct pilot {
    float open, seen, choice; ///< of rsv_bake_estimate
    float light;              ///< luminance of all
} pilot;

typedef struct grid_light {
    const rsv_light_view *s;
    const rsv_bake_grid *grid;
    const rsv_bake_accuracy *accuracy;
    size_t count;
    pilot *pilot;     ///< [count]
    rsv_rgb *half[2]; ///< [count] of what is sampled
    rsv_rgb *light;   ///< [count] of the rest
} grid_light;

/// @param round other random numbers
static rsv_bake_estimate look(grid_light *q, size_t k, uint32_t samples, uint32_t round)
{
    rsv_bake_patch patch;
    uint32_t number = q->grid->patch(q->grid->user, k, &patch);
    rsv_bake_estimate e =
        rsv_bake_estimate_patch(q->s, &patch, samples, rsv_hash3(q->accuracy->seed, number, round));
    q->light[k] = q->grid->sampled_only ? e.punctual : rgb_add(e.stored, e.punctual);
    q->half[0][k] = e.half[0];
    q->half[1][k] = e.half[1];
    return e;
}

static void take_pilots(grid_light *q)
{
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(q->s->context))
    for (size_t k = 0; k < q->count; k++) {
        if (q->grid->group[k] == RSV_NONE || rsv_cancelled(q->s->context)) continue;
        rsv_bake_estimate e = look(q, k, q->grid->pilot_samples, 0);
        q->pilot[k] =
            (pilot){ e.open, e.seen, e.choice, rgb_luminance(rsv_bake_estimate_total(&e)) };
    }
}

/// Means over a patch and its neighbours: one that asked itself alone would stop where its few rays happen to agree.
static pilot look_around(const grid_light *q, size_t at)
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(at % grid->width), y = (long)(at / grid->width);
    pilot mean = { 0, 0, 0, 0 };
    float count = 0;
    for (long b = y - PILOT_REACH; b <= y + PILOT_REACH; b++)
        for (long a = x - PILOT_REACH; a <= x + PILOT_REACH; a++) {
            if (a < 0 || b < 0 || a >= (long)grid->width || b >= (long)grid->height) continue;
            size_t n = (size_t)b * grid->width + (size_t)a;
            if (grid->group[n] != grid->group[at]) continue;
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
static uint32_t wanted_samples(const grid_light *q, size_t at)
{
    pilot p = look_around(q, at);
    float by_shadow = p.open * p.open * f_max(p.seen * (1 - p.seen), 0);
    float variance = STRATIFIED * (by_shadow + p.choice);
    if (!(variance > 0)) return 0;
    float deviation = FILTER_GAIN * q->accuracy->error * f_max(p.light, q->accuracy->dark);
    float samples = 0.5f * variance / (deviation * deviation);
    return (uint32_t)f_min(f_max(samples, LEAST_SAMPLES), MOST_LIGHT_SAMPLES);
}

static rsv_status send_rays(grid_light *q)
{
    rsv_context *context = q->s->context;
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context))
    for (size_t k = 0; k < q->count; k++) {
        if (rsv_thread_index() == 0 && k % 64 == 0)
            rsv_progress(context, "bake", (double)k / (double)q->count);
        if (q->grid->group[k] == RSV_NONE || rsv_cancelled(context)) continue;
        uint32_t samples = wanted_samples(q, k);
        if (samples > 0) look(q, k, samples, 1); // independent of the pilot, which chose how many
    }
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

static rsv_status estimate(grid_light *q)
{
    rsv_status status;
    const rsv_bake_grid *grid = q->grid;
    const rsv_bake_noisy_map noisy = { grid->width, grid->height, grid->group,
        { q->half[0], q->half[1] } };
    take_pilots(q);
    RSV_TRY(send_rays(q));
    if (rsv_lights_any_sampled(q->s->lights)) RSV_TRY(rsv_bake_filter(q->s->context, &noisy));
    for (size_t k = 0; k < q->count; k++)
        q->light[k] =
            rgb_positive(rgb_mad(q->light[k], 0.5f, rgb_add(q->half[0][k], q->half[1][k])));
cleanup:
    return status;
}

rsv_status rsv_bake_light_grid(const rsv_light_view *s, const rsv_bake_grid *grid,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light)
{
    rsv_context *context = s->context;
    rsv_status status = RSV_ERROR_MEMORY;
    grid_light q = { .s = s,
        .grid = grid,
        .accuracy = accuracy,
        .count = (size_t)grid->width * grid->height,
        .light = light };
    q.pilot = rsv_alloc(context, q.count, sizeof *q.pilot);
    for (int h = 0; h < 2; h++)
        q.half[h] = rsv_alloc(context, q.count, sizeof *q.half[h]);
    for (size_t k = 0; k < q.count; k++)
        light[k] = rgb_gray(0);
    if (q.pilot && q.half[0] && q.half[1]) status = estimate(&q);
    rsv_free(context, q.pilot);
    rsv_free(context, q.half[0]);
    rsv_free(context, q.half[1]);
    return status;
}
