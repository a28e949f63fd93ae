#include "bake_judge.h"

#include "../core/parallel.h"
#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_gather.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- which values ---------------------------------------------------------------------------------

static bool wants(void *user, const uint32_t at[2], const uint32_t size[2])
{
    const rsv_bake_judge *j = user;
    double chance = j->wanted / ((double)size[0] * size[1]);
    uint32_t drawn = rsv_hash3(at[0], at[1], 0x6a756467u);
    return j->count < j->capacity && drawn < chance * 4294967296.0;
}

static void take(void *user, const rsv_bake_value *value)
{
    rsv_bake_judge *j = user;
    if (value->translucent || value->place_count == 0 || j->count == j->capacity) return;
    rsv_bake_judged *judged = &j->value[j->count++];
    judged->light = value->irradiance;
    judged->patch.count = value->place_count;
    memcpy(judged->patch.place, value->place, value->place_count * sizeof *value->place);
}

rsv_status rsv_bake_judge_create(
    const rsv_light_view *light, uint32_t wanted, rsv_bake_judge *judge)
{
    *judge = (rsv_bake_judge){ .light = light, .wanted = wanted };
    judge->visitor = (rsv_bake_visitor){ judge, wants, take };
    if (wanted == 0) return RSV_OK;
    judge->capacity = 2 * (size_t)wanted + 16; // it is left to chance how many there are
    judge->value = rsv_alloc(light->context, judge->capacity, sizeof *judge->value);
    return judge->value ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_bake_judge_destroy(rsv_bake_judge *judge)
{
    if (judge->light) rsv_free(judge->light->context, judge->value);
    judge->value = NULL;
}

// ---- independent estimates -----------------------------------------------------------------------

/// With as many shadow rays as it takes: few find the last of a penumbra.
static rsv_bake_estimate estimate_direct(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, uint32_t seed, float dark)
{
    uint32_t samples = JUDGED_SHADOW_RAYS;
    rsv_bake_estimate e = rsv_bake_estimate_patch(lamps, patch, samples, seed);
    float least = f_max(rgb_luminance(rsv_bake_estimate_total(&e)), dark);
    float off = rsv_bake_estimate_error(&e, samples) / (JUDGED_NOISE * least);
    if (!(off > 1)) return e;
    samples = (uint32_t)f_min((float)samples * off * off, MOST_JUDGED_SHADOW_RAYS);
    return rsv_bake_estimate_patch(lamps, patch, samples, rsv_hash2(seed, 1));
}

/// An independent estimate, luminance, and its standard error.
typedef struct judgement {
    double light, noise;
} judgement;

/// One batch of gather rays over a patch.
static double gather_batch(const rsv_light_view *s, const rsv_bake_patch *patch, uint32_t seed)
{
    rsv_rgb sum = rgb_gray(0);
    uint32_t rays = JUDGED_GATHER_RAYS / patch->count;
    for (uint32_t k = 0; k < patch->count; k++)
        sum = rgb_add(sum, rsv_bake_gather(s, &patch->place[k], rays, rsv_hash3(seed, k, 0x67u)));
    return (double)rgb_luminance(sum) / patch->count;
}

/// @param direct light that is already known, to which noise is relative
static judgement gather(
    const rsv_light_view *s, const rsv_bake_patch *patch, uint32_t seed, double direct, float dark)
{
    double sum = 0, squares = 0;
    judgement j = { 0, 0 };
    for (uint32_t n = 1; n <= MOST_JUDGED_BATCHES && !rsv_cancelled(s->context); n++) {
        double batch = gather_batch(s, patch, rsv_hash2(seed, n));
        sum += batch;
        squares += batch * batch;
        j.light = sum / n;
        if (n < LEAST_JUDGED_BATCHES) continue;
        j.noise = sqrt(fmax(squares / n - j.light * j.light, 0) / (n - 1));
        if (j.noise <= (double)JUDGED_NOISE * fmax(direct + j.light, (double)dark)) break;
    }
    return j;
}

static judgement estimate(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, uint32_t seed, float dark)
{
    rsv_bake_estimate e = estimate_direct(lamps, patch, seed, dark);
    double half[2];
    for (int h = 0; h < 2; h++)
        half[h] = (double)rgb_luminance(rgb_add(e.half[h], e.punctual));
    double direct = 0.5 * (half[0] + half[1]);
    judgement j = gather(lamps->light, patch, seed, direct, dark);
    j.noise = hypot(j.noise, 0.5 * (half[0] - half[1]));
    j.light += direct;
    return j;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double percentile(double *value, size_t count, double share)
{
    qsort(value, count, sizeof *value, compare);
    return value[(size_t)(share * (double)(count - 1) + 0.5)];
}

/// Values and their independent estimates.
typedef struct comparison {
    const rsv_bake_judge *judge;
    rsv_bake_lamps lamps;
    float dark;
    double *error, *noise; ///< [count] relative; noise is the standard error of the estimate
} comparison;

static void compare_span(void *job, rsv_span span)
{
    const comparison *c = job;
    const rsv_light_view *s = c->judge->light;
    for (size_t n = span.begin; n < span.end; n++) {
        const rsv_bake_judged *judged = &c->judge->value[n];
        c->error[n] = c->noise[n] = 0;
        if (rsv_cancelled(s->context)) continue;
        uint32_t seed = rsv_hash3(s->desc.seed, (uint32_t)n, 0x6a75u);
        judgement j = estimate(&c->lamps, &judged->patch, seed, c->dark);
        double least = fmax(j.light, (double)c->dark);
        if (!(least > 0)) continue;
        c->error[n] = fabs((double)rgb_luminance(judged->light) - j.light) / least;
        c->noise[n] = j.noise / least;
    }
}

/// @param error, noise out: [count], see comparison
static rsv_status compare_values(
    const rsv_bake_judge *judge, float dark, double *error, double *noise)
{
    const rsv_light_view *s = judge->light;
    comparison c = { judge, { .light = s }, dark, error, noise };
    rsv_status status = rsv_bake_sources_create(s->context, s->lights, &c.lamps.sources);
    if (status != RSV_OK) return status;
    rsv_parallel_for(s->context, judge->count, 1, compare_span, &c);
    rsv_bake_sources_destroy(&c.lamps.sources);
    return rsv_cancelled(s->context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

rsv_status rsv_bake_judge_finish(const rsv_bake_judge *judge, float dark, rsv_bake_report *report)
{
    rsv_status status;
    if (judge->count == 0) return RSV_OK;
    rsv_context *context = judge->light->context;
    double *error = rsv_alloc(context, judge->count, sizeof *error),
           *noise = rsv_alloc(context, judge->count, sizeof *noise);
    RSV_TRY(error && noise ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(compare_values(judge, dark, error, noise));
    report->judged = judge->count;
    report->error_median = percentile(error, judge->count, 0.5);
    report->error_99 = percentile(error, judge->count, 0.99);
    report->error_noise = percentile(noise, judge->count, 0.5);
cleanup:
    rsv_free(context, error);
    rsv_free(context, noise);
    return status;
}
