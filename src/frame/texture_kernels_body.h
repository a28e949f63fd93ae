/// Texels of sixteen pixels, included by glossy_kernels_body.h: as rsv_texture_at finds them, except for the rounding of
/// the level.
#include "../scene/material_at.h"
#include "../scene/tangent.h"
#include "../scene/texture.h"
#include "../scene/texture_triangle.h"

/// A texel's codes of 16 bits, and one more.
static inline rsv_float4 texel_at(const uint16_t *code)
{
#if defined(__SSE2__)
    __m128i codes = _mm_loadl_epi64((const void *)code);
    return (rsv_float4)_mm_cvtepi32_ps(_mm_unpacklo_epi16(codes, _mm_setzero_si128()));
#else
    return (rsv_float4){ (float)code[0], (float)code[1], (float)code[2], (float)code[3] };
#endif
}

/// Where lanes look a texture up.
typedef struct texture_lanes {
    float u[LANES], v[LANES];
    int level[2][LANES];  ///< of the pyramid, the finer one first
    float coarser[LANES]; ///< share of the second
} __attribute__((aligned(64))) texture_lanes;

/// log2 within 0.01.
static inline float rough_log2(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    float exponent = (float)(int)(bits >> 23) - 127;
    bits = (bits & 0x7fffff) | 0x3f800000;
    memcpy(&x, &bits, sizeof x);
    return exponent + (2 - (1.0f / 3) * x) * x - 5.0f / 3;
}

/// Texels per square metre of a triangle.
static inline float texel_density(const rsv_scene_view *scene, const rsv_texture *texture,
    const rsv_texture_triangle *t, const uint32_t *corner)
{
    rsv_vec3 edge1, edge2;
    rsv_triangle_edges(scene, corner, &edge1, &edge2);
    float texels = fabsf(rsv_texture_area(t)) * (float)texture->level[0].width *
                   (float)texture->level[0].height;
    return texels / v3_length(v3_cross(edge1, edge2));
}

/// Triangles of the lanes in texture coordinates.
typedef struct chart_lanes {
    float u[LANES], v[LANES], du[2][LANES], dv[2][LANES];
    float density[LANES]; ///< texels per square metre
} __attribute__((aligned(64))) chart_lanes;

/// The same triangle in the lanes from `first` to before `end`.
static inline void set_charts(
    const rsv_texture_triangle *t, float density, int first, int end, chart_lanes *restrict to)
{
    for (int k = first; k < end; k++) {
        to->u[k] = t->u, to->v[k] = t->v;
        to->du[0][k] = t->du[0], to->du[1][k] = t->du[1];
        to->dv[0][k] = t->dv[0], to->dv[1][k] = t->dv[1];
        to->density[k] = density;
    }
}

/// @param triangle of each lane
static inline void find_charts(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const int *restrict triangle, chart_lanes *restrict to)
{
    const rsv_texture *texture = &scene->texture[ref->texture];
    for (int k = 0, end; k < LANES; k = end) {
        const uint32_t *corner = scene->triangle[triangle[k]];
        rsv_texture_triangle t = rsv_texture_triangle_of(scene, ref, corner);
        for (end = k + 1; end < LANES && triangle[end] == triangle[k];)
            end++;
        set_charts(&t, texel_density(scene, texture, &t, corner), k, end, to);
    }
}

/// Two levels are blended only in half of the range between them, so that most packets need one.
static inline float share_of_coarser(float between)
{
    return f_min(f_max(2 * between - 0.5f, 0), 1);
}

/// @param triangle of each lane @param width of the lanes' footprints, metres
static inline void find_texture_lanes(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const int *restrict triangle, const rsv_ray_packet *restrict p, const float *restrict width,
    texture_lanes *restrict to)
{
    chart_lanes chart;
    int last = (int)scene->texture[ref->texture].level_count - 1;
    find_charts(scene, ref, triangle, &chart);
    for (int k = 0; k < LANES; k++) {
        float u = p->u[k], v = p->v[k];
        to->u[k] = rsv_tame(chart.u[k] + u * chart.du[0][k] + v * chart.du[1][k]);
        to->v[k] = rsv_tame(chart.v[k] + u * chart.dv[0][k] + v * chart.dv[1][k]);
    }
    for (int k = 0; k < LANES; k++) {
        float texels = f_min(f_max(width[k] * width[k] * chart.density[k], 1), 1e30f);
        float level = f_min(f_max(0.5f * rough_log2(texels), 0), (float)last);
        int finer = (int)level, coarser = finer + 1 < last ? finer + 1 : last;
        float share = share_of_coarser(level - (float)finer);
        to->level[0][k] = share < 1 ? finer : coarser;
        to->level[1][k] = coarser;
        to->coarser[k] = share < 1 ? share : 0;
    }
}

static inline int floor_of(float x)
{
    int whole = (int)x;
    return whole - (x < (float)whole ? 1 : 0);
}

/// Coordinates moved into the picture, as it repeats.
static inline void wrap_coordinates(rsv_wrap wrap, float *restrict x)
{
    if (wrap == RSV_WRAP_REPEAT)
        for (int k = 0; k < LANES; k++)
            x[k] -= (float)floor_of(x[k]);
    else if (wrap == RSV_WRAP_CLAMP)
        for (int k = 0; k < LANES; k++)
            x[k] = f_min(f_max(x[k], 0), 1);
    else
        for (int k = 0; k < LANES; k++) {
            float turn = x[k] - 2 * (float)floor_of(0.5f * x[k]), back = 2 - turn;
            x[k] = turn > 1 ? back : turn;
        }
}

/// Columns, or rows, of texels to both sides of places. @param place in 0..1 @param share of the second, out
static inline void find_texels(const float *restrict place, const int *restrict size, rsv_wrap wrap,
    int (*restrict texel)[LANES], float *restrict share)
{
    for (int k = 0; k < LANES; k++) {
        float x = place[k] * (float)size[k] - 0.5f;
        int first = floor_of(x), last = size[k] - 1, second = first + 1;
        share[k] = x - (float)first;
        bool repeats = wrap == RSV_WRAP_REPEAT;
        first = first < 0 ? (repeats ? last : 0) : first;
        second = second > last ? (repeats ? 0 : last) : second;
        texel[0][k] = first < last ? first : last;
        texel[1][k] = second;
    }
}

/// Adds the colours of texels, times their weights: lane by lane, a whole texel at a time.
static inline void add_texels(
    const rsv_texture *texture, const rsv_texel_lanes *restrict from, rsv_float4 *restrict color)
{
    for (int k = 0; k < LANES; k++) {
        rsv_float4 sum = color[k];
        for (int corner = 0; corner < 4; corner++)
            sum += from->weight[corner][k] * texel_at(texture->unorm + from->index[corner][k]);
        color[k] = sum;
    }
}

/// Sizes of levels of the pyramid.
typedef struct level_lanes {
    int width[LANES], height[LANES], first[LANES];
} __attribute__((aligned(64))) level_lanes;

static inline void set_levels(
    const rsv_texture_level *level, int first, int end, level_lanes *restrict to)
{
    int width = (int)level->width, height = (int)level->height, texel = (int)level->first;
    for (int k = first; k < end; k++)
        to->width[k] = width, to->height[k] = height, to->first[k] = texel;
}

static inline void find_levels(
    const rsv_texture *texture, const int *restrict level, level_lanes *restrict to)
{
    if (all_equal(level)) {
        set_levels(&texture->level[level[0]], 0, LANES, to);
        return;
    }
    for (int k = 0; k < LANES; k++)
        set_levels(&texture->level[level[k]], k, k + 1, to);
}

/// Finds the texels of a mip level. @param share weight of the level in the colour
static inline void find_level(const rsv_texture *texture, const texture_lanes *restrict at,
    const int *restrict level, const float *restrict share, rsv_texel_lanes *restrict to)
{
    level_lanes size;
    _Alignas(64) int column[2][LANES], row[2][LANES];
    _Alignas(64) float across[LANES], down[LANES];
    int channels = (int)texture->channel_count;
    find_levels(texture, level, &size);
    find_texels(at->u, size.width, texture->wrap_u, column, across);
    find_texels(at->v, size.height, texture->wrap_v, row, down);
    for (int k = 0; k < LANES; k++) {
        int above = size.first[k] + row[0][k] * size.width[k];
        int below = size.first[k] + row[1][k] * size.width[k];
        float upper = share[k] * (1.0f / 65535) * (1 - down[k]);
        float lower = share[k] * (1.0f / 65535) * down[k];
        to->index[0][k] = (above + column[0][k]) * channels;
        to->index[1][k] = (above + column[1][k]) * channels;
        to->index[2][k] = (below + column[0][k]) * channels;
        to->index[3][k] = (below + column[1][k]) * channels;
        to->weight[0][k] = upper * (1 - across[k]);
        to->weight[1][k] = upper * across[k];
        to->weight[2][k] = lower * (1 - across[k]);
        to->weight[3][k] = lower * across[k];
    }
}

/// Finds the texels that lanes read.
static inline void find_texels_of(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const int *restrict triangle, const rsv_ray_packet *restrict p, const float *restrict width,
    rsv_texels_ahead *restrict to)
{
    const rsv_texture *texture = &scene->texture[ref->texture];
    _Alignas(64) float finer[LANES];
    texture_lanes at;
    find_texture_lanes(scene, ref, triangle, p, width, &at);
    wrap_coordinates(texture->wrap_u, at.u);
    wrap_coordinates(texture->wrap_v, at.v);
    for (int k = 0; k < LANES; k++)
        finer[k] = 1 - at.coarser[k];
    to->both = any_positive(at.coarser);
    find_level(texture, &at, at.level[0], finer, &to->level[0]);
    if (to->both) find_level(texture, &at, at.level[1], at.coarser, &to->level[1]);
}

/// Prefetches the same texels of another texture.
static inline void approach_texels(const rsv_texture *texture, const rsv_texel_lanes *restrict at)
{
    for (int k = 0; k < LANES; k++) {
        __builtin_prefetch(texture->unorm + at->index[0][k]);
        __builtin_prefetch(texture->unorm + at->index[2][k]);
    }
}

/// The colours of texels. @param color [3][LANES] out
static inline void read_texels(const rsv_texture *texture, const rsv_texels_ahead *restrict from,
    float (*restrict color)[LANES])
{
    rsv_float4 sum[LANES];
    memset(sum, 0, sizeof sum);
    add_texels(texture, &from->level[0], sum);
    if (from->both) add_texels(texture, &from->level[1], sum);
    for (int k = 0; k < LANES; k++)
        for (int c = 0; c < 3; c++)
            color[c][k] = sum[k][c];
}
