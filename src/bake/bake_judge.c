#include "bake_judge.h"

#include "../core/sampling.h"
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

// ---- the same light anew --------------------------------------------------------------------------

/// Both halves of the light of a patch, luminance.
static void estimate(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, uint32_t seed, double half[2])
{
    rsv_bake_estimate e = rsv_bake_estimate_patch(lamps, patch, JUDGED_SHADOW_RAYS, seed);
    uint32_t rays = JUDGED_GATHER_RAYS / patch->count;
    for (uint32_t h = 0; h < 2; h++) {
        rsv_rgb gathered = rgb_gray(0);
        for (uint32_t k = 0; k < patch->count; k++)
            gathered = rgb_mad(gathered, 1 / (float)patch->count,
                rsv_bake_gather(
                    lamps->light, &patch->place[k], rays, rsv_hash3(seed, 2 * k + h, 0x67u)));
        half[h] = (double)rgb_luminance(rgb_add(gathered, rgb_add(e.half[h], e.punctual)));
    }
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

/// @param error, noise out: [count] relative; noise is what the estimate itself is off by
static rsv_status compare_values(
    const rsv_bake_judge *judge, float dark, double *error, double *noise)
{
    const rsv_light_view *s = judge->light;
    rsv_bake_lamps lamps = { .light = s };
    rsv_status status = rsv_bake_sources_create(s->context, s->lights, &lamps.sources);
    if (status != RSV_OK) return status;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(s->context))
    for (size_t n = 0; n < judge->count; n++) {
        const rsv_bake_judged *judged = &judge->value[n];
        double half[2];
        error[n] = noise[n] = 0;
        if (rsv_cancelled(s->context)) continue;
        estimate(&lamps, &judged->patch, rsv_hash3(s->desc.seed, (uint32_t)n, 0x6a75u), half);
        double mean = 0.5 * (half[0] + half[1]), least = fmax(mean, (double)dark);
        error[n] = least > 0 ? fabs((double)rgb_luminance(judged->light) - mean) / least : 0;
        noise[n] = least > 0 ? 0.5 * fabs(half[0] - half[1]) / least : 0;
    }
    rsv_bake_sources_destroy(&lamps.sources);
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
