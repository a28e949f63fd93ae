#include "fredholm.h"

#include <math.h>
#include <string.h>

/// Light that has not begun to die out after so many orders never will.
#define MAX_STEPS 64

/// <w, source> / (|w| |source|), the largest of the channels.
static double compatibility(const float *w, const float *source, size_t count)
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

rsv_status rsv_fredholm_alternative(
    const rsv_linear_map *map, const float *source, rsv_alternative *alternative)
{
    rsv_status status;
    float *vector = rsv_alloc(map->context, 3 * map->count, sizeof *vector);
    rsv_power_desc desc = { .max_steps = MAX_STEPS, .gap = -1, .doubt = RSV_LOSSLESS };
    *alternative = (rsv_alternative){ 0 };
    if (!vector) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_power_iteration(map, &desc, vector, &alternative->radius));
    alternative->unique = alternative->radius.power < RSV_LOSSLESS;
    if (!alternative->unique) {
        rsv_spectral_radius adjoint;
        desc.transposed = true;
        RSV_TRY(rsv_power_iteration(map, &desc, vector, &adjoint));
        alternative->compatibility = compatibility(vector, source, map->count);
    }
cleanup:
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
