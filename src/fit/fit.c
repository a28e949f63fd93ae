#include "../core/descriptor.h"
#include "bounded.h"
#include "readings.h"

#include "../core/core.h"
#include "../scene/placed_luminaire.h"
#include "../sources/punctual_light.h"

#include <math.h>
#include <string.h>
#include <time.h>

#define HIGHEST 1e6

struct rsv_fit {
    rsv_context *context;
    rsv_fit_desc desc;
    rsv_light_responses *responses;
    size_t count;     ///< points
    rsv_rgb *reading; ///< [count][responses->count] W/m2
    rsv_rgb *wanted;  ///< [count]
    double *weight;   ///< [count]
    double *lumens;   ///< [responses->count]
    bool *kept;       ///< [light_count]
    rsv_rgb *factor;  ///< [light_count]
    double mean;      ///< of the targets
    rsv_fit_report report;
};

void rsv_fit_desc_init(rsv_fit_desc *desc, size_t size)
{
    const rsv_fit_desc defaults = {
        .size = sizeof defaults, .highest = 1, .saving = 1e-6, .samples = 512
    };
    rsv_desc_fill(desc, size, &defaults);
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// ---- lights -----------------------------------------------------------------------------------------

static double lumens_of(const rsv_lights *lights)
{
    double sum = 0;
    for (size_t g = 0; g < lights->group_count; g++)
        if (!lights->group[g].muted) sum += RSV_LUMEN_PER_WATT * lights->group[g].power;
    for (size_t k = 0; k < lights->punctual_count; k++)
        sum += rsv_punctual_lumens(lights->scene, &lights->scene->light[lights->punctual[k]]);
    return sum;
}

/// Marks lights that stay as they are. @return whether the name is known
static bool keep_light(rsv_fit *f, const char *pattern)
{
    bool known = false;
    for (size_t k = 0; k < f->responses->count; k++) {
        bool meant = rsv_name_is_meant(pattern, f->responses->name[k]) ||
                     rsv_name_is_meant(pattern, f->responses->definition[k]);
        f->kept[k] = f->kept[k] || meant;
        known = known || meant;
    }
    return known;
}

static rsv_status find_lights(rsv_fit *f)
{
    size_t count = f->responses->count, free = count;
    f->lumens = rsv_alloc(f->context, count, sizeof *f->lumens);
    f->kept = rsv_alloc(f->context, count, sizeof *f->kept);
    f->factor = rsv_alloc(f->context, count, sizeof *f->factor);
    if (!f->lumens || !f->kept || !f->factor) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        f->factor[k] = rgb_gray(1);
        f->lumens[k] = lumens_of(f->responses->view[k]->lights);
        f->report.lumens_before += f->lumens[k];
        // surroundings have one factor for all colours
        f->kept[k] = f->desc.colors && f->responses->sky_last && k + 1 == count;
    }
    for (size_t k = 0; k < f->desc.keep_count; k++)
        if (!keep_light(f, f->desc.keep[k]))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "fit: there is no light '%.200s' to keep; `resolvent info` lists them",
                f->desc.keep[k]);
    for (size_t k = 0; k < count; k++)
        free -= f->kept[k];
    if (free) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT, "fit: there is no light to change");
}

// ---- least squares ----------------------------------------------------------------------------------

/// One channel, or the luminance. @param channel 0..2; 3 = lux
static double part_of(rsv_rgb value, int channel)
{
    if (channel == 3) return RSV_LUMEN_PER_WATT * (double)rgb_luminance(value);
    return (double)(&value.r)[channel];
}

static void fill_problem(const rsv_fit *f, int channel, double *a, double *b)
{
    size_t lights = f->responses->count;
    for (size_t i = 0; i < f->count; i++) {
        b[i] = (double)(&f->wanted[i].r)[channel % 3] / f->mean;
        for (size_t k = 0; k < lights; k++)
            a[i * lights + k] = part_of(f->reading[i * lights + k], channel) / f->mean;
    }
}

/// @param bound low, high and cost, [lights] each
static void fill_bounds(const rsv_fit *f, double *low, double *high, double *cost)
{
    double most = 0;
    for (size_t k = 0; k < f->responses->count; k++)
        most += f->lumens[k] * f->desc.highest;
    for (size_t k = 0; k < f->responses->count; k++) {
        low[k] = f->kept[k] ? 1 : f->desc.lowest;
        high[k] = f->kept[k] ? 1 : f->desc.highest;
        cost[k] = most > 0 ? f->desc.saving * f->lumens[k] / most : 0;
    }
}

static void take_factors(rsv_fit *f, int channel, const double *x)
{
    for (size_t k = 0; k < f->responses->count; k++) {
        if (channel == 3)
            f->factor[k] = rgb_gray((float)x[k]);
        else
            (&f->factor[k].r)[channel] = (float)x[k];
    }
}

static rsv_status fit_channel(rsv_fit *f, int channel)
{
    rsv_bounded_report report;
    size_t lights = f->responses->count;
    double *memory = rsv_alloc(f->context, f->count * (lights + 1) + 4 * lights, sizeof *memory);
    if (!memory) return RSV_ERROR_MEMORY;
    double *a = memory, *b = a + f->count * lights, *low = b + f->count, *high = low + lights,
           *cost = high + lights, *x = cost + lights;
    fill_problem(f, channel, a, b);
    fill_bounds(f, low, high, cost);
    for (size_t k = 0; k < lights; k++)
        x[k] = high[k];
    const rsv_bounded problem = { f->context, f->count, lights, a, b, f->weight, cost, low, high,
        f->desc.at_least };
    rsv_status status = rsv_bounded_solve(&problem, x, &report);
    if (status == RSV_OK) take_factors(f, channel, x);
    f->report.kkt_residual = fmax(f->report.kkt_residual, report.kkt_residual);
    f->report.iterations += report.iterations;
    rsv_free(f->context, memory);
    return status;
}

rsv_rgb rsv_fit_reading(const rsv_fit *f, size_t index)
{
    size_t lights = f->responses->count;
    rsv_rgb sum = rgb_gray(0);
    for (size_t k = 0; k < lights; k++)
        sum = rgb_add(sum, rgb_mul(f->factor[k], f->reading[index * lights + k]));
    return f->desc.colors ? sum : rgb((float)part_of(sum, 3), 0, 0);
}

/// Error of a reading.
static double error_of(const rsv_fit *f, size_t index, int channel)
{
    rsv_rgb reading = rsv_fit_reading(f, index);
    double error = (double)(&reading.r)[channel] - (double)(&f->wanted[index].r)[channel];
    return f->desc.at_least && error > 0 ? 0 : fabs(error);
}

static void report_errors(rsv_fit *f)
{
    double squares = 0;
    int channels = f->desc.colors ? 3 : 1;
    for (size_t i = 0; i < f->count; i++)
        for (int c = 0; c < channels && f->weight[i] > 0; c++) {
            double error = error_of(f, i, c);
            squares += error * error;
            if (error <= f->report.error_largest) continue;
            f->report.error_largest = error;
            f->report.worst = i;
        }
    f->report.error_rms = sqrt(squares / ((double)f->count * channels)) / f->mean;
    for (size_t k = 0; k < f->responses->count; k++)
        f->report.lumens +=
            f->lumens[k] * (double)(f->desc.colors ? rgb_luminance(f->factor[k]) : f->factor[k].r);
}

static rsv_status fit_all(rsv_fit *f)
{
    rsv_status status = RSV_OK;
    double started = seconds();
    for (int c = f->desc.colors ? 0 : 3; c < (f->desc.colors ? 3 : 4) && status == RSV_OK; c++)
        status = fit_channel(f, c);
    if (status == RSV_OK) report_errors(f);
    f->report.time_fit = seconds() - started;
    return status;
}

// ---- the whole --------------------------------------------------------------------------------------

static rsv_status check_desc(const rsv_fit_desc *d)
{
    if (!(d->lowest >= 0) || !(d->highest >= d->lowest) || !(d->highest <= HIGHEST))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "fit: factors from %g to %g are not a range within 0 to %g", d->lowest, d->highest,
            HIGHEST);
    if (!(d->saving >= 0) || !isfinite(d->saving))
        return rsv_fail(RSV_ERROR_ARGUMENT, "fit: a saving of %g is not possible", d->saving);
    return RSV_OK;
}

static rsv_status take_wanted(rsv_fit *f, const rsv_fit_wanted *wanted)
{
    double sum = 0, weights = 0;
    int channels = f->desc.colors ? 3 : 1;
    f->wanted = rsv_alloc(f->context, f->count, sizeof *f->wanted);
    f->weight = rsv_alloc(f->context, f->count, sizeof *f->weight);
    if (!f->wanted || !f->weight) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < f->count; i++) {
        f->wanted[i] = wanted[i].reading;
        f->weight[i] = (double)wanted[i].weight;
        weights += f->weight[i];
        for (int c = 0; c < channels; c++) {
            float value = (&f->wanted[i].r)[c];
            if (!(value >= 0) || !isfinite(value) || !(f->weight[i] >= 0) ||
                !isfinite(f->weight[i]))
                return rsv_fail(RSV_ERROR_ARGUMENT,
                    "fit: point %zu: readings and weights must be from 0 on", i + 1);
            sum += (double)value;
        }
    }
    f->mean = sum / ((double)f->count * channels);
    for (size_t i = 0; i < f->count && weights > 0; i++)
        f->weight[i] /= weights;
    if (f->mean > 0 && weights > 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT, "fit: no point has a target above 0");
}

rsv_status rsv_fit_create(const rsv_light *light, const rsv_fit_wanted *wanted, size_t count,
    const rsv_fit_desc *desc, rsv_fit **fit)
{
    rsv_status status;
    const rsv_light_view *view = rsv_light_get_view(light);
    rsv_fit *f = rsv_alloc(view->context, 1, sizeof *f);
    if (!f) return RSV_ERROR_MEMORY;
    *f = (rsv_fit){ .context = view->context, .desc = rsv_default_fit_desc(), .count = count };
    double started = seconds();
    RSV_TRY(RSV_READ_DESC(rsv_fit_desc, &f->desc, desc));
    RSV_TRY(check_desc(&f->desc));
    if (!count) RSV_TRY(rsv_fail(RSV_ERROR_ARGUMENT, "fit: there are no target readings"));
    RSV_TRY(take_wanted(f, wanted));
    RSV_TRY(rsv_light_responses_create(light, &f->responses));
    RSV_TRY(find_lights(f));
    f->reading = rsv_alloc(f->context, count * f->responses->count, sizeof *f->reading);
    RSV_TRY(f->reading ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_fit_read(view, f->responses, wanted, count, &f->desc, f->reading));
    f->report.time_readings = seconds() - started;
    RSV_TRY(fit_all(f));
    *fit = f;
    f = NULL;
cleanup:
    rsv_fit_destroy(f);
    return status;
}

void rsv_fit_destroy(rsv_fit *f)
{
    if (!f) return;
    rsv_light_responses_destroy(f->responses);
    rsv_free(f->context, f->reading);
    rsv_free(f->context, f->wanted);
    rsv_free(f->context, f->weight);
    rsv_free(f->context, f->lumens);
    rsv_free(f->context, f->kept);
    rsv_free(f->context, f->factor);
    rsv_free(f->context, f);
}

size_t rsv_fit_light_count(const rsv_fit *f) { return f->responses->count; }

rsv_fit_light rsv_fit_get_light(const rsv_fit *f, size_t k)
{
    return (rsv_fit_light){ .name = f->responses->name[k],
        .factor = f->factor[k],
        .scale = rgb_mul(f->factor[k], f->responses->scale[k]),
        .lumens = f->lumens[k],
        .kept = f->kept[k] };
}

rsv_fit_report rsv_fit_get_report(const rsv_fit *f) { return f->report; }
