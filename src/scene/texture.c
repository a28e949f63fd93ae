#include "texture.h"

#include "../core/parallel.h"
#include "../core/srgb.h"
#include "texture_body.h"

#include <string.h>

static rsv_status check_desc(const rsv_texture_desc *desc, const char *name)
{
    if (desc->width == 0 || desc->height == 0 || desc->width > RSV_TEXTURE_MAX_SIDE ||
        desc->height > RSV_TEXTURE_MAX_SIDE)
        return rsv_fail(RSV_ERROR_FORMAT, "texture '%s': %u x %u texels are not in 1 .. %u a side",
            name, desc->width, desc->height, RSV_TEXTURE_MAX_SIDE);
    if (desc->channel_count < 1 || desc->channel_count > 4)
        return rsv_fail(RSV_ERROR_ARGUMENT, "texture '%s': %u channels are not in 1 .. 4", name,
            desc->channel_count);
    return RSV_OK;
}

/// Lays the levels out one after the other. @return texels of all of them
static size_t plan_levels(rsv_texture *t, uint32_t width, uint32_t height)
{
    size_t texels = 0;
    for (;;) {
        t->level[t->level_count++] = (rsv_texture_level){ width, height, texels };
        texels += (size_t)width * height;
        if (width == 1 && height == 1) return texels;
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
    }
}

static uint16_t to_unorm(double value) { return (uint16_t)(65535 * value + 0.5); }

static void decode_codes(rsv_texture *t, const rsv_texture_desc *desc)
{
    uint16_t linear[256], curved[256];
    uint32_t channels = desc->channel_count, alpha = channels % 2 == 0 ? channels - 1 : channels;
    for (int code = 0; code < 256; code++) {
        linear[code] = to_unorm(code / 255.0);
        curved[code] = to_unorm(rsv_srgb_decode(code / 255.0));
    }
    for (size_t i = 0; i < (size_t)desc->width * desc->height; i++)
        for (uint32_t c = 0; c < channels; c++) {
            size_t k = i * channels + c;
            t->unorm[k] = (desc->srgb && c != alpha ? curved : linear)[desc->codes[k]];
        }
}

/// @return how many values were not finite
static size_t copy_values(rsv_texture *t, const rsv_texture_desc *desc)
{
    size_t unusable = 0;
    for (size_t k = 0; k < (size_t)desc->width * desc->height * desc->channel_count; k++) {
        bool usable = isfinite(desc->values[k]);
        t->value[k] = usable ? desc->values[k] : 0;
        unusable += !usable;
    }
    return unusable;
}

static double stored(const rsv_texture *t, size_t index)
{
    return t->unorm ? t->unorm[index] / 65535.0 : (double)t->value[index];
}

/// How much of source texel `k` lies in [begin, end).
static double overlap(uint32_t k, double begin, double end)
{
    return fmin(k + 1.0, end) - fmax(k, begin);
}

/// Sums over the area that one texel of the coarser level covers, weighted by area: odd sizes leave no texel out and
/// count none twice.
typedef struct texel_sums {
    double plain[4];
    double covered[4]; ///< the same times alpha
} texel_sums;

static texel_sums sum_texels(const rsv_texture *t, uint32_t coarse, uint32_t i, uint32_t j)
{
    const rsv_texture_level *to = &t->level[coarse], *from = &t->level[coarse - 1];
    double step_x = (double)from->width / to->width, step_y = (double)from->height / to->height;
    double left = i * step_x, right = left + step_x, top = j * step_y, bottom = top + step_y;
    texel_sums sums = { { 0 }, { 0 } };
    for (uint32_t y = (uint32_t)top; y < from->height && y < bottom; y++)
        for (uint32_t x = (uint32_t)left; x < from->width && x < right; x++) {
            double weight = overlap(x, left, right) * overlap(y, top, bottom);
            weight /= step_x * step_y;
            size_t texel = (from->first + (size_t)y * from->width + x) * t->channel_count;
            double alpha = stored(t, texel + t->channel_count - 1);
            for (uint32_t c = 0; c < t->channel_count; c++) {
                sums.plain[c] += weight * stored(t, texel + c);
                sums.covered[c] += weight * alpha * stored(t, texel + c);
            }
        }
    return sums;
}

/// Rounds a nonzero mean up to at least one step, so that lamps of a single texel are found in coarser levels.
static uint16_t to_unorm_above_zero(double mean)
{
    uint16_t code = to_unorm(mean);
    return code == 0 && mean > 0 ? 1 : code;
}

static void reduce_texel(rsv_texture *t, uint32_t coarse, uint32_t i, uint32_t j)
{
    const rsv_texture_level *to = &t->level[coarse];
    texel_sums sums = sum_texels(t, coarse, i, j);
    size_t texel = (to->first + (size_t)j * to->width + i) * t->channel_count;
    uint32_t alpha = t->channel_count - 1;
    for (uint32_t c = 0; c < t->channel_count; c++) {
        bool weighed = t->covers && c != alpha && sums.plain[alpha] > 0;
        double mean = weighed ? sums.covered[c] / sums.plain[alpha] : sums.plain[c];
        if (t->unorm)
            t->unorm[texel + c] = to_unorm_above_zero(fmin(mean, 1));
        else
            t->value[texel + c] = (float)mean;
    }
}

typedef struct reduction {
    rsv_texture *texture;
    uint32_t level; ///< computed from the level before it
} reduction;

static void reduce_rows(void *job, rsv_span span)
{
    const reduction *r = job;
    for (size_t j = span.begin; j < span.end; j++)
        for (uint32_t i = 0; i < r->texture->level[r->level].width; i++)
            reduce_texel(r->texture, r->level, i, (uint32_t)j);
}

static void reduce(rsv_context *context, rsv_texture *t)
{
    for (reduction r = { t, 1 }; r.level < t->level_count; r.level++) {
        uint32_t height = t->level[r.level].height;
        rsv_parallel_for(context, height, height >= 256 ? 0 : 256, reduce_rows, &r);
    }
}

static const char *name_of(const rsv_texture_desc *desc)
{
    return desc->name && *desc->name ? desc->name : "unnamed";
}

/// A texture without texels.
static rsv_status create_blank(
    rsv_context *context, const rsv_texture_desc *desc, bool floats, rsv_texture *texture)
{
    rsv_status status = check_desc(desc, name_of(desc));
    if (status != RSV_OK) return status;
    *texture = (rsv_texture){ .name = rsv_copy_string(context, name_of(desc)),
        .channel_count = desc->channel_count,
        .wrap_u = desc->wrap_u,
        .wrap_v = desc->wrap_v,
        .nearest = desc->nearest };
    size_t count = plan_levels(texture, desc->width, desc->height) * desc->channel_count;
    if (floats)
        texture->value = rsv_alloc(context, count, sizeof *texture->value);
    else
        texture->unorm = rsv_alloc(context, count + 1, sizeof *texture->unorm);
    if (texture->name && (texture->unorm || texture->value)) return RSV_OK;
    rsv_texture_release(context, texture);
    return RSV_ERROR_MEMORY;
}

rsv_status rsv_texture_create_linear(rsv_context *context, const rsv_texture_desc *desc,
    const uint16_t *linear, rsv_texture *texture)
{
    rsv_status status = create_blank(context, desc, false, texture);
    if (status != RSV_OK) return status;
    size_t count = (size_t)desc->width * desc->height * desc->channel_count;
    memcpy(texture->unorm, linear, count * sizeof *linear);
    reduce(context, texture);
    return RSV_OK;
}

rsv_status rsv_texture_create(
    rsv_context *context, const rsv_texture_desc *desc, rsv_texture *texture)
{
    const char *name = name_of(desc);
    if (!desc->codes == !desc->values)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "texture '%s': needs either codes or values, not both", name);
    rsv_status status = create_blank(context, desc, desc->values != NULL, texture);
    if (status != RSV_OK) return status;
    size_t unusable = 0;
    if (desc->codes)
        decode_codes(texture, desc);
    else
        unusable = copy_values(texture, desc);
    if (unusable)
        rsv_log(context, RSV_LOG_WARNING, "texture '%s': %zu values are not finite and count as 0",
            name, unusable);
    reduce(context, texture);
    return RSV_OK;
}

void rsv_texture_add_use(rsv_context *context, rsv_texture *texture, bool alpha_is_opacity)
{
    texture->whole = texture->whole || !alpha_is_opacity;
    bool covers = !texture->whole && texture->channel_count % 2 == 0;
    if (covers == texture->covers) return;
    texture->covers = covers;
    reduce(context, texture);
}

void rsv_texture_release(rsv_context *context, rsv_texture *texture)
{
    rsv_free(context, texture->name);
    rsv_free(context, texture->unorm);
    rsv_free(context, texture->value);
}
