#include "spectrum.h"

#include <math.h>
#include <string.h>

uint32_t rsv_neumann_terms(double radius, double size, double target)
{
    if (!(size > target) || radius <= 0) return 0;
    if (radius >= 1 || target <= 0) return UINT32_MAX;
    double terms = ceil(log(target / size) / log(radius));
    return terms < UINT32_MAX ? (uint32_t)terms : UINT32_MAX;
}

static double largest(const float *field, size_t count, size_t channel)
{
    double max = 0;
    for (size_t n = 0; n < count; n++)
        max = fmax(max, (double)field[3 * n + channel]);
    return max;
}

/// Bounds of one channel, then image = image / max image, which is returned.
static double next_iterate(
    const float *vector, float *image, size_t count, size_t channel, rsv_spectral_radius *radius)
{
    double low = INFINITY, high = 0, size = largest(image, count, channel);
    for (size_t n = channel; n < 3 * count; n += 3) {
        if (vector[n] <= 0) continue;
        double ratio = (double)image[n] / vector[n];
        low = fmin(low, ratio);
        high = fmax(high, ratio);
    }
    for (size_t n = channel; n < 3 * count && size > 0; n += 3)
        image[n] = (float)(image[n] / size);
    if (isfinite(low)) radius->lower = fmax(radius->lower, low);
    radius->upper = fmax(radius->upper, high);
    return size;
}

/// ||A^k 1|| of a channel as a running product, and the sum of those before it.
typedef struct power_norm {
    double norm, sum;
} power_norm;

/// The resolvent is sum A^n = (sum over n < k of A^n) (I - A^k)^-1.
static double bound_resolvent(const power_norm power[3])
{
    double bound = 0;
    for (int c = 0; c < 3; c++)
        bound = fmax(bound, power[c].norm < 1 ? power[c].sum / (1 - power[c].norm) : INFINITY);
    return bound;
}

static void take_step(const rsv_linear_map *map, const rsv_power_desc *desc, const float *vector,
    float *image, power_norm power[3], rsv_spectral_radius *radius)
{
    uint32_t step = ++radius->applications;
    (desc->transposed ? map->table->apply_transpose : map->table->apply)(
        map->data, 3, vector, image);
    radius->lower = radius->upper = 0;
    double norm = 0;
    for (size_t c = 0; c < 3; c++) {
        power[c].sum += power[c].norm;
        power[c].norm *= next_iterate(vector, image, map->count, c, radius);
        norm = fmax(norm, power[c].norm);
        radius->size[c] = power[c].norm;
    }
    if (desc->transposed) return;
    if (step == 1) radius->norm = norm;
    radius->power = pow(norm, 1.0 / step);
    radius->resolvent = fmin(radius->resolvent, bound_resolvent(power));
}

rsv_status rsv_power_iteration(const rsv_linear_map *map, const rsv_power_desc *desc, float *vector,
    rsv_spectral_radius *radius)
{
    rsv_context *context = map->context;
    size_t values = 3 * map->count;
    rsv_status status = RSV_OK;
    float *image = rsv_alloc(context, values, sizeof *image);
    if (!image) return RSV_ERROR_MEMORY;
    *radius = (rsv_spectral_radius){ .norm = NAN, .power = NAN, .resolvent = INFINITY };
    power_norm power[3] = { { 1, 0 }, { 1, 0 }, { 1, 0 } };
    for (size_t k = 0; k < values; k++)
        vector[k] = 1;
    for (uint32_t step = 1; step <= desc->max_steps && status == RSV_OK; step++) {
        take_step(map, desc, vector, image, power, radius);
        memcpy(vector, image, values * sizeof *vector);
        bool certain = radius->upper - radius->lower <= desc->gap;
        // the first step's bounds count rows that are 0 although they carry no part of the spectrum
        if ((step > 1 && certain) || radius->power < desc->doubt) break;
        status = rsv_progress(context, "spectrum", (double)step / desc->max_steps);
    }
    rsv_free(context, image);
    return status;
}
