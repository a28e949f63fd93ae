#include "fredholm.h"

#include <math.h>
#include <string.h>

static double cosine_between(const float *w, const float *source, size_t count)
{
    double most = 0;
    for (size_t c = 0; c < 3; c++) {
        double product = 0, ww = 0, ss = 0;
        for (size_t n = c; n < 3 * count; n += 3) {
            product += (double)w[n] * source[n];
            ww += (double)w[n] * w[n];
            ss += (double)source[n] * source[n];
        }
        if (ww > 0 && ss > 0) most = fmax(most, fabs(product) / sqrt(ww * ss));
    }
    return most;
}

static rsv_status iterate(
    const rsv_linear_map *map, bool transposed, float *vector, rsv_spectral_radius *radius)
{
    rsv_power_desc desc = {
        .max_steps = RSV_LOSSLESS_ORDERS, .gap = -1, .doubt = RSV_LOSSLESS, .transposed = transposed
    };
    return vector ? rsv_power_iteration(map, &desc, vector, radius) : RSV_ERROR_MEMORY;
}

rsv_status rsv_fredholm_alternative(
    const rsv_linear_map *map, rsv_alternative *alternative, float *lasting)
{
    float *vector = rsv_alloc(map->context, 3 * map->count, sizeof *vector);
    *alternative = (rsv_alternative){ 0 };
    rsv_status status = iterate(map, false, vector, &alternative->radius);
    alternative->unique = status == RSV_OK && alternative->radius.power < RSV_LOSSLESS;
    for (size_t i = 0; status == RSV_OK && lasting && i < 3 * map->count; i++)
        lasting[i] = (float)(vector[i] * alternative->radius.size[i % 3]);
    rsv_free(map->context, vector);
    return status;
}

rsv_status rsv_fredholm_compatibility(
    const rsv_linear_map *map, const float *source, double *compatibility)
{
    rsv_spectral_radius adjoint;
    float *vector = rsv_alloc(map->context, 3 * map->count, sizeof *vector);
    rsv_status status = iterate(map, true, vector, &adjoint);
    *compatibility = status == RSV_OK ? cosine_between(vector, source, map->count) : NAN;
    rsv_free(map->context, vector);
    return status;
}

rsv_status rsv_survival(
    const rsv_linear_map *map, const float *area, uint32_t orders, float *survival)
{
    float *next = rsv_alloc(map->context, 3 * map->count, sizeof *next);
    if (!next) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < 3 * map->count; i++)
        survival[i] = area[i / 3];
    for (uint32_t order = 0; order < orders; order++) {
        map->table->apply_transpose(map->data, 3, survival, next);
        memcpy(survival, next, 3 * map->count * sizeof *next);
    }
    for (size_t i = 0; i < 3 * map->count; i++)
        survival[i] = area[i / 3] > 0 ? survival[i] / area[i / 3] : 0;
    rsv_free(map->context, next);
    return RSV_OK;
}
