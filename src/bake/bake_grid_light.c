#include "bake_grid_light.h"

#include "../core/parallel.h"
#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_filter.h"
#include "bake_grid_open.h"

#include <string.h>

/// Result of a patch's first few shadow rays.
typedef struct pilot {
    float open, seen, choice; ///< of rsv_bake_estimate
    float light;              ///< luminance of all
    bool known;
} pilot;

typedef struct grid_light {
    const rsv_light_view *s;
    rsv_bake_lamps lamps; ///< of that
    const rsv_bake_grid *grid;
    const rsv_bake_accuracy *accuracy;
    size_t count;
    pilot *pilot;         ///< [count]
    rsv_rgb *half[2];     ///< [count] light found by shadow rays
    rsv_rgb *filtered[2]; ///< [count] the same without noise
    uint16_t *samples;    ///< [count] shadow rays of each half; 0 = taken from neighbours
    rsv_rgb *light;       ///< [count] of the rest
    rsv_bake_grid_open open;
    const uint32_t *group; ///< [count] of patches in the open
} grid_light;

static void patch_in_the_open(
    const grid_light *q, size_t k, rsv_bake_patch *patch, uint32_t *number)
{
    *number = q->grid->patch(q->grid->user, k, patch);
    rsv_bake_remove_places(patch, q->open.covered[k]);
}

/// @param round other random numbers
static rsv_bake_estimate look(grid_light *q, size_t k, uint32_t samples, uint32_t round)
{
    rsv_bake_patch patch;
    uint32_t number;
    patch_in_the_open(q, k, &patch, &number);
    rsv_bake_estimate e = rsv_bake_estimate_patch(
        &q->lamps, &patch, samples, rsv_hash3(q->accuracy->seed, number, round));
    q->light[k] = e.stored;
    q->samples[k] = (uint16_t)samples;
    q->half[0][k] = rgb_add(e.half[0], e.punctual);
    q->half[1][k] = rgb_add(e.half[1], e.punctual);
    return e;
}

// ---- patches between others -----------------------------------------------------------------------

/// Neighbouring patches in even columns and rows whose mean may replace it; 0 if it is sampled itself.
static uint32_t find_leads(const grid_light *q, size_t at, size_t lead[4])
{
    const rsv_bake_grid *grid = q->grid;
    uint32_t x = (uint32_t)(at % grid->width), y = (uint32_t)(at / grid->width), count = 0;
    if (x % 2 == 0 && y % 2 == 0) return 0;
    for (uint32_t b = y - y % 2; b <= y + y % 2; b += 2)
        for (uint32_t a = x - x % 2; a <= x + x % 2; a += 2) {
            size_t n = (size_t)b * grid->width + a;
            if (a >= grid->width || b >= grid->height || q->group[n] != q->group[at]) return 0;
            lead[count++] = n;
        }
    return count;
}

/// Means over the surrounding pilot patches: a patch that used only its own rays would stop where they happen to agree.
static pilot look_around(const grid_light *q, size_t at)
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(at % grid->width), y = (long)(at / grid->width);
    pilot mean = { 0, 0, 0, 0, true };
    float count = 0;
    for (long b = y - PILOT_REACH; b <= y + PILOT_REACH; b++)
        for (long a = x - PILOT_REACH; a <= x + PILOT_REACH; a++) {
            if (a < 0 || b < 0 || a >= (long)grid->width || b >= (long)grid->height) continue;
            size_t n = (size_t)b * grid->width + (size_t)a;
            const pilot *p = &q->pilot[n];
            if (q->group[n] != q->group[at] || !p->known) continue;
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

/// Whether sources are seen in part.
static bool is_mixed(const pilot *p) { return p->seen > 0 && p->seen < 1; }

/// Takes the mean of the neighbouring patches, if there is no shadow edge and light varies slowly.
static bool interpolate(grid_light *q, size_t at, const size_t *lead, uint32_t count)
{
    const pilot around = look_around(q, at);
    float low = INFINITY, high = 0;
    rsv_rgb mean[2] = { rgb_gray(0), rgb_gray(0) };
    if (is_mixed(&around)) return false;
    for (uint32_t k = 0; k < count; k++) {
        float luminance = 0;
        for (int h = 0; h < 2; h++) {
            mean[h] = rgb_mad(mean[h], 1 / (float)count, q->half[h][lead[k]]);
            luminance += 0.5f * rgb_luminance(q->half[h][lead[k]]);
        }
        low = f_min(low, luminance);
        high = f_max(high, luminance);
    }
    if (high - low > MOST_SLOPE * f_max(around.light, q->accuracy->dark)) return false;
    q->half[0][at] = mean[0];
    q->half[1][at] = mean[1];
    rsv_bake_patch patch;
    uint32_t number;
    patch_in_the_open(q, at, &patch, &number);
    q->light[at] = rsv_bake_stored_mean(q->s, &patch);
    return true;
}

// ---- shadow rays ----------------------------------------------------------------------------------

static void take_pilots(void *job, rsv_span span)
{
    grid_light *q = job;
    for (size_t k = span.begin; k < span.end; k++) {
        size_t lead[4];
        if (q->group[k] == RSV_NONE || rsv_cancelled(q->s->context) || find_leads(q, k, lead) > 0)
            continue;
        rsv_bake_estimate e = look(q, k, q->grid->pilot_samples, 0);
        q->pilot[k] =
            (pilot){ e.open, e.seen, e.choice, rgb_luminance(rsv_bake_estimate_total(&e)), true };
    }
}

/// Shadow rays of each half that the target error requires; 0 = those of the pilot suffice.
static uint32_t wanted_samples(const grid_light *q, size_t at)
{
    const pilot p = look_around(q, at);
    float by_shadow = p.open * p.open * f_max(p.seen * (1 - p.seen), 0);
    float variance = STRATIFIED * (by_shadow + p.choice);
    if (!(variance > 0)) return 0;
    float deviation = FILTER_GAIN * q->accuracy->error * f_max(p.light, q->accuracy->dark);
    float samples = 0.5f * variance / (deviation * deviation);
    if (!is_mixed(&p) && samples <= (float)q->grid->pilot_samples) return 0;
    return (uint32_t)f_min(f_max(samples, LEAST_SAMPLES), MOST_LIGHT_SAMPLES);
}

/// @param between patches, not those that stand for themselves
static void send_ray_span(grid_light *q, rsv_span span, bool between)
{
    rsv_context *context = q->s->context;
    if (span.worker == 0) rsv_progress(context, "bake", (double)span.begin / (double)q->count);
    for (size_t k = span.begin; k < span.end; k++) {
        size_t lead[4];
        if (q->group[k] == RSV_NONE || rsv_cancelled(context)) continue;
        uint32_t leads = find_leads(q, k, lead);
        if ((leads > 0) != between || (between && interpolate(q, k, lead, leads))) continue;
        uint32_t samples = wanted_samples(q, k);
        if (samples == 0 && between) samples = q->grid->pilot_samples;
        if (samples > 0) look(q, k, samples, 1); // independent of the pilot, which chose how many
    }
}

static void send_rays_of_leads(void *job, rsv_span span) { send_ray_span(job, span, false); }

static void send_rays_between(void *job, rsv_span span) { send_ray_span(job, span, true); }

static rsv_status send_rays(grid_light *q)
{
    rsv_context *context = q->s->context;
    rsv_parallel_for(context, q->count, 64, send_rays_of_leads, q);
    rsv_parallel_for(context, q->count, 64, send_rays_between, q);
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

// ---- where penumbrae fade out ----------------------------------------------------------------------

static float sampled_luminance(const grid_light *q, size_t k)
{
    return rgb_luminance(q->half[0][k]) + rgb_luminance(q->half[1][k]);
}

/// Shadow rays for a patch without light next to one with light; 0 = not such a patch, or already sampled.
static uint32_t beside_light(const grid_light *q, size_t at)
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(at % grid->width), y = (long)(at / grid->width);
    uint32_t samples = 0;
    if (q->samples[at] >= LEAST_SAMPLES || sampled_luminance(q, at) > 0) return 0;
    for (long b = y - 1; b <= y + 1; b++)
        for (long a = x - 1; a <= x + 1; a++) {
            if (a < 0 || b < 0 || a >= (long)grid->width || b >= (long)grid->height) continue;
            size_t n = (size_t)b * grid->width + (size_t)a;
            if (q->group[n] != q->group[at] || !(sampled_luminance(q, n) > 0)) continue;
            uint32_t theirs = q->samples[n] > LEAST_SAMPLES ? q->samples[n] : LEAST_SAMPLES;
            if (theirs > samples) samples = theirs;
        }
    return samples;
}

/// A round in which some patches send more shadow rays.
typedef struct round_job {
    grid_light *grid;
    uint32_t round;
    uint16_t *wanted;   ///< [count] shadow rays; of penumbrae
    atomic_size_t sent; ///< patches that did send
} round_job;

static void want_rays(void *job, rsv_span span)
{
    const round_job *r = job;
    const grid_light *q = r->grid;
    for (size_t k = span.begin; k < span.end; k++)
        r->wanted[k] = q->group[k] == RSV_NONE ? 0 : (uint16_t)beside_light(q, k);
}

static void send_wanted(void *job, rsv_span span)
{
    round_job *r = job;
    for (size_t k = span.begin; k < span.end; k++) {
        if (r->wanted[k] == 0 || rsv_cancelled(r->grid->s->context)) continue;
        look(r->grid, k, r->wanted[k], 1);
        atomic_fetch_add_explicit(&r->sent, 1, memory_order_relaxed);
    }
}

/// Follows penumbrae to where no more light is found: few rays of pilots miss the last of it.
static rsv_status follow_penumbrae(grid_light *q)
{
    rsv_context *context = q->s->context;
    round_job r = { .grid = q, .sent = 1 };
    r.wanted = rsv_alloc(context, q->count, sizeof *r.wanted);
    if (!r.wanted) return RSV_ERROR_MEMORY;
    for (; r.round < PENUMBRA_ROUNDS && r.sent > 0 && !rsv_cancelled(context); r.round++) {
        r.sent = 0;
        rsv_parallel_for(context, q->count, 256, want_rays, &r);
        rsv_parallel_for(context, q->count, 64, send_wanted, &r);
    }
    rsv_free(context, r.wanted);
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

// ---- remaining noise -----------------------------------------------------------------------------

/// Standard error of a patch, relative: half the difference of the halves, in the mean of squares over its neighbours.
static float error_around(const grid_light *q, size_t at)
{
    const rsv_bake_grid *grid = q->grid;
    long x = (long)(at % grid->width), y = (long)(at / grid->width);
    float squares = 0, count = 0;
    for (long b = y - 1; b <= y + 1; b++)
        for (long a = x - 1; a <= x + 1; a++) {
            if (a < 0 || b < 0 || a >= (long)grid->width || b >= (long)grid->height) continue;
            size_t n = (size_t)b * grid->width + (size_t)a;
            if (q->group[n] != q->group[at] || q->samples[n] == 0) continue;
            float difference = rgb_luminance(q->filtered[0][n]) - rgb_luminance(q->filtered[1][n]);
            squares += 0.25f * difference * difference;
            count++;
        }
    rsv_rgb sampled = rgb_scale(rgb_add(q->filtered[0][at], q->filtered[1][at]), 0.5f);
    float light = rgb_luminance(rgb_add(q->light[at], sampled));
    return sqrtf(squares / f_max(count, 1)) / f_max(light, q->accuracy->dark);
}

/// Sends four times the shadow rays where the error is larger than that of most patches may be.
static void refine(void *job, rsv_span span)
{
    round_job *r = job;
    grid_light *q = r->grid;
    for (size_t k = span.begin; k < span.end; k++) {
        if (q->group[k] == RSV_NONE || q->samples[k] == 0 ||
            q->samples[k] >= MOST_REFINED_SAMPLES || rsv_cancelled(q->s->context) ||
            error_around(q, k) <= q->accuracy->largest)
            continue;
        uint32_t samples = 4u * q->samples[k];
        if (samples > MOST_REFINED_SAMPLES) samples = MOST_REFINED_SAMPLES;
        look(q, k, samples, 2 + r->round);
        atomic_fetch_add_explicit(&r->sent, 1, memory_order_relaxed);
    }
}

static rsv_status quieten(grid_light *q)
{
    rsv_status status;
    const rsv_bake_grid *grid = q->grid;
    const rsv_bake_noisy_map noisy = { grid->width, grid->height, q->group,
        { q->half[0], q->half[1] }, { q->filtered[0], q->filtered[1] } };
    round_job r = { .grid = q, .sent = 1 };
    RSV_TRY(rsv_bake_filter(q->s->context, &noisy));
    for (; r.round < LIGHT_REFINEMENTS && r.sent > 0; r.round++) {
        r.sent = 0;
        rsv_parallel_for(q->s->context, q->count, 64, refine, &r);
        if (r.sent > 0) RSV_TRY(rsv_bake_filter(q->s->context, &noisy));
    }
cleanup:
    return status;
}

static rsv_status estimate(grid_light *q)
{
    rsv_status status;
    rsv_parallel_for(q->s->context, q->count, 256, take_pilots, q);
    RSV_TRY(send_rays(q));
    bool noisy = rsv_lights_any_sampled(q->s->lights) || q->s->lights->punctual_tree;
    if (noisy) RSV_TRY(follow_penumbrae(q));
    if (noisy) RSV_TRY(quieten(q));
    rsv_rgb *const *half = noisy ? q->filtered : q->half;
    for (size_t k = 0; k < q->count; k++)
        q->light[k] = rgb_positive(rgb_mad(q->light[k], 0.5f, rgb_add(half[0][k], half[1][k])));
    rsv_bake_grid_open_fill(&q->open, q->light);
cleanup:
    return status;
}

static void free_arrays(grid_light *q)
{
    rsv_context *context = q->s->context;
    rsv_bake_sources_destroy(&q->lamps.sources);
    rsv_bake_grid_open_destroy(&q->open);
    rsv_free(context, q->pilot);
    rsv_free(context, q->samples);
    for (int h = 0; h < 2; h++) {
        rsv_free(context, q->half[h]);
        rsv_free(context, q->filtered[h]);
    }
}

rsv_status rsv_bake_light_grid(const rsv_light_view *s, const rsv_bake_grid *grid,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light, uint32_t *stand_in)
{
    rsv_status status;
    grid_light q = { .s = s,
        .grid = grid,
        .accuracy = accuracy,
        .count = (size_t)grid->width * grid->height,
        .light = light };
    q.pilot = rsv_alloc(s->context, q.count, sizeof *q.pilot);
    q.samples = rsv_alloc(s->context, q.count, sizeof *q.samples);
    bool allocated = q.pilot && q.samples;
    for (int h = 0; h < 2; h++) {
        q.half[h] = rsv_alloc(s->context, q.count, sizeof *q.half[h]);
        q.filtered[h] = rsv_alloc(s->context, q.count, sizeof *q.filtered[h]);
        allocated = allocated && q.half[h] && q.filtered[h];
    }
    for (size_t k = 0; k < q.count; k++)
        light[k] = rgb_gray(0);
    q.lamps.light = s;
    RSV_TRY(rsv_bake_grid_open_create(s, grid, &q.open));
    q.group = q.open.group;
    RSV_TRY(rsv_bake_sources_create(s->context, s->lights, &q.lamps.sources));
    status = allocated ? estimate(&q) : RSV_ERROR_MEMORY;
    if (stand_in) memcpy(stand_in, q.open.stand_in, q.count * sizeof *stand_in);
cleanup:
    free_arrays(&q);
    return status;
}
