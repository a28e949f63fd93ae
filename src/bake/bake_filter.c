#include "bake_filter.h"

#include "../core/parallel.h"
#include "../core/vec.h"
#include "bake_constants.h"

typedef struct filter {
    const rsv_context *context;
    const rsv_bake_noisy_map *map;
    float *luminance[2]; ///< [texels] of the halves
    float *variance;     ///< [texels] of the luminance of a half, a mean over neighbours
} filter;

static bool is_beside(const rsv_bake_noisy_map *map, uint32_t group, long x, long y, size_t *texel)
{
    if (x < 0 || y < 0 || x >= (long)map->width || y >= (long)map->height) return false;
    *texel = (size_t)y * map->width + (size_t)x;
    return map->group[*texel] == group;
}

/// Half the squared difference of the halves is the variance of one; the mean over a few neighbours is less noisy
/// itself.
static void find_variance(const filter *f, size_t texel)
{
    const rsv_bake_noisy_map *map = f->map;
    long x = (long)(texel % map->width), y = (long)(texel / map->width);
    float sum = 0, count = 0;
    size_t n;
    for (long b = y - VARIANCE_REACH; b <= y + VARIANCE_REACH; b++)
        for (long a = x - VARIANCE_REACH; a <= x + VARIANCE_REACH; a++) {
            if (!is_beside(map, map->group[texel], a, b, &n)) continue;
            float difference = f->luminance[0][n] - f->luminance[1][n];
            sum += 0.5f * difference * difference;
            count++;
        }
    f->variance[texel] = count > 0 ? sum / count : 0;
}

/// Squared distance of two texels' neighbourhoods in one half, relative to that expected from noise.
static float distance(const filter *f, int half, size_t p, size_t q)
{
    const rsv_bake_noisy_map *map = f->map;
    const float *l = f->luminance[half], *v = f->variance;
    long px = (long)(p % map->width), py = (long)(p / map->width);
    long qx = (long)(q % map->width), qy = (long)(q / map->width);
    float sum = 0, count = 0;
    for (long dy = -PATCH_REACH; dy <= PATCH_REACH; dy++)
        for (long dx = -PATCH_REACH; dx <= PATCH_REACH; dx++) {
            size_t a, b;
            if (!is_beside(map, map->group[p], px + dx, py + dy, &a) ||
                !is_beside(map, map->group[p], qx + dx, qy + dy, &b))
                continue;
            float difference = l[a] - l[b], noise = v[a] + v[b];
            float explained = v[a] + f_min(v[a], v[b]);
            sum += (difference * difference - explained) /
                   (FILTER_STRENGTH * FILTER_STRENGTH * noise + 1e-20f);
            count++;
        }
    return count > 0 ? f_max(sum / count, 0) : 0;
}

/// @param result out: both halves of a texel, each filtered with weights from the other
static void filter_texel(const filter *f, size_t texel, rsv_rgb result[2])
{
    const rsv_bake_noisy_map *map = f->map;
    long x = (long)(texel % map->width), y = (long)(texel / map->width);
    float weight[2] = { 0, 0 };
    size_t n;
    result[0] = rgb_gray(0);
    result[1] = rgb_gray(0);
    for (long b = y - FILTER_REACH; b <= y + FILTER_REACH; b++)
        for (long a = x - FILTER_REACH; a <= x + FILTER_REACH; a++) {
            if (!is_beside(map, map->group[texel], a, b, &n)) continue;
            for (int h = 0; h < 2; h++) {
                float w = n == texel ? 1 : expf(-distance(f, 1 - h, texel, n));
                result[h] = rgb_mad(result[h], w, map->half[h][n]);
                weight[h] += w;
            }
        }
    for (int h = 0; h < 2; h++)
        result[h] = rgb_scale(result[h], 1 / weight[h]);
}

static void find_luminance(void *job, rsv_span span)
{
    const filter *f = job;
    for (size_t k = span.begin; k < span.end; k++)
        for (int h = 0; h < 2; h++)
            f->luminance[h][k] = rgb_luminance(f->map->half[h][k]);
}

static void find_variances(void *job, rsv_span span)
{
    const filter *f = job;
    for (size_t k = span.begin; k < span.end; k++)
        if (f->map->group[k] != RSV_NONE) find_variance(f, k);
}

static void filter_texels(void *job, rsv_span span)
{
    const filter *f = job;
    const rsv_bake_noisy_map *map = f->map;
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_rgb result[2] = { map->half[0][k], map->half[1][k] };
        // where the halves agree, all of a source is visible, or none: there is no noise to filter
        bool noisy = map->group[k] != RSV_NONE && f->luminance[0][k] != f->luminance[1][k] &&
                     !rsv_cancelled(f->context);
        if (noisy) filter_texel(f, k, result);
        map->filtered[0][k] = result[0];
        map->filtered[1][k] = result[1];
    }
}

static rsv_status run(rsv_context *context, filter *f)
{
    size_t texels = (size_t)f->map->width * f->map->height;
    rsv_parallel_for(context, texels, 1024, find_luminance, f);
    rsv_parallel_for(context, texels, 1024, find_variances, f);
    rsv_parallel_for(context, texels, 256, filter_texels, f);
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

rsv_status rsv_bake_filter(rsv_context *context, const rsv_bake_noisy_map *map)
{
    rsv_status status = RSV_ERROR_MEMORY;
    size_t texels = (size_t)map->width * map->height;
    filter f = { .context = context, .map = map };
    f.variance = rsv_alloc(context, texels, sizeof *f.variance);
    for (int h = 0; h < 2; h++)
        f.luminance[h] = rsv_alloc(context, texels, sizeof *f.luminance[h]);
    if (f.variance && f.luminance[0] && f.luminance[1]) status = run(context, &f);
    rsv_free(context, f.variance);
    rsv_free(context, f.luminance[0]);
    rsv_free(context, f.luminance[1]);
    return status;
}
