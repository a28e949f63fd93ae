/// Lookup in textures (texture.h).
#ifndef RSV_TEXTURE_BODY_H
#define RSV_TEXTURE_BODY_H

#include "texture.h"
#include "texture_triangle.h"

/// Texel index for position `k` on a side of `size` texels.
RSV_INLINE uint32_t rsv_wrapped(int64_t k, uint32_t size, rsv_wrap wrap)
{
    int64_t n = size;
    if (k >= 0 && k < n) return (uint32_t)k;
    if (wrap == RSV_WRAP_CLAMP) return (uint32_t)(k < 0 ? 0 : k >= n ? n - 1 : k);
    int64_t period = wrap == RSV_WRAP_MIRROR ? 2 * n : n;
    k %= period;
    if (k < 0) k += period;
    return (uint32_t)(k < n ? k : 2 * n - 1 - k);
}

RSV_INLINE rsv_texel rsv_texel_of(float r, float g, float b, float a)
{
    rsv_texel texel = { r, g, b, a };
    return texel;
}

/// @param x, y inside the level
RSV_INLINE rsv_texel rsv_texel_inside(
    const rsv_texture *t, const rsv_texture_level *level, uint32_t x, uint32_t y)
{
    size_t first = (level->first + (size_t)y * level->width + x) * t->channel_count;
    if (t->unorm && t->channel_count >= 3) { // nearly all
        const uint16_t *code = t->unorm + first;
        const float unit = 1.0f / 65535;
        return rsv_texel_of((float)code[0] * unit, (float)code[1] * unit, (float)code[2] * unit,
            t->channel_count == 4 ? (float)code[3] * unit : 1);
    }
    float c[4] = { 0, 0, 0, 0 };
    for (uint32_t k = 0; k < t->channel_count; k++)
        c[k] = t->unorm ? (float)t->unorm[first + k] * (1.0f / 65535) : t->value[first + k];
    bool colored = t->channel_count >= 3, covers = t->channel_count % 2 == 0;
    return rsv_texel_of(
        c[0], colored ? c[1] : c[0], colored ? c[2] : c[0], covers ? c[t->channel_count - 1] : 1);
}

RSV_INLINE rsv_texel rsv_texel_at(
    const rsv_texture *t, const rsv_texture_level *level, int64_t i, int64_t j)
{
    return rsv_texel_inside(t, level, rsv_wrapped(i, level->width, t->wrap_u),
        rsv_wrapped(j, level->height, t->wrap_v));
}

RSV_INLINE rsv_texel rsv_texel_mix(rsv_texel a, rsv_texel b, float share)
{
    return rsv_texel_of(a.r + share * (b.r - a.r), a.g + share * (b.g - a.g),
        a.b + share * (b.b - a.b), a.a + share * (b.a - a.a));
}

/// Mixes colours weighted by alpha, so that invisible texels do not affect visible ones; unweighted if both are
/// invisible.
RSV_INLINE rsv_texel rsv_texel_mix_covers(rsv_texel a, rsv_texel b, float share)
{
    float alpha = a.a + share * (b.a - a.a);
    rsv_texel mix = rsv_texel_mix(a, b, alpha > 0 ? share * b.a / alpha : share);
    mix.a = alpha;
    return mix;
}

RSV_INLINE rsv_texel rsv_texel_between(const rsv_texture *t, rsv_texel a, rsv_texel b, float share)
{
    return t->covers ? rsv_texel_mix_covers(a, b, share) : rsv_texel_mix(a, b, share);
}

RSV_INLINE rsv_texel rsv_texture_bilinear(const rsv_texture *t, uint32_t index, float u, float v)
{
    const rsv_texture_level *level = &t->level[index];
    float x = u * (float)level->width, y = v * (float)level->height;
    if (t->nearest && index == 0)
        return rsv_texel_at(t, level, (int64_t)floorf(x), (int64_t)floorf(y));
    float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    float right_share = x - 0.5f - left, bottom_share = y - 0.5f - top;
    int64_t i = (int64_t)left, j = (int64_t)top;
    uint32_t x0 = rsv_wrapped(i, level->width, t->wrap_u),
             x1 = rsv_wrapped(i + 1, level->width, t->wrap_u),
             y0 = rsv_wrapped(j, level->height, t->wrap_v),
             y1 = rsv_wrapped(j + 1, level->height, t->wrap_v);
    rsv_texel upper = rsv_texel_between(
        t, rsv_texel_inside(t, level, x0, y0), rsv_texel_inside(t, level, x1, y0), right_share);
    rsv_texel lower = rsv_texel_between(
        t, rsv_texel_inside(t, level, x0, y1), rsv_texel_inside(t, level, x1, y1), right_share);
    return rsv_texel_between(t, upper, lower, bottom_share);
}

RSV_SHARED rsv_texel rsv_texture_lookup(const rsv_texture *t, float u, float v, float level)
{
    u = rsv_tame(u), v = rsv_tame(v);
    if (!(level > 0)) return rsv_texture_bilinear(t, 0, u, v);
    uint32_t last = t->level_count - 1;
    if (level >= (float)last) return rsv_texture_bilinear(t, last, u, v);
    uint32_t finer = (uint32_t)level;
    return rsv_texel_between(t, rsv_texture_bilinear(t, finer, u, v),
        rsv_texture_bilinear(t, finer + 1, u, v), level - (float)finer);
}

RSV_SHARED rsv_texel rsv_texture_mean(const rsv_texture *t)
{
    return rsv_texel_at(t, &t->level[t->level_count - 1], 0, 0);
}

#endif
