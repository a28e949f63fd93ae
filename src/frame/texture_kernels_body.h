/// Base colors of sixteen pixels, included by glossy_kernels_body.h: rsv_base_color_at, but for the rounding of the level.
#include "../scene/material_at.h"
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

/// @param triangle of each lane @param width of the lanes' footprints, metres
static inline void find_texture_lanes(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const int *restrict triangle, const rsv_ray_packet *restrict p, const float *restrict width,
    texture_lanes *restrict to)
{
    const rsv_texture *texture = &scene->texture[ref->texture];
    rsv_texture_triangle t = { 0 };
    _Alignas(64) float density[LANES];
    float last = (float)(texture->level_count - 1);
    for (int k = 0; k < LANES; k++) {
        const uint32_t *corner = scene->triangle[triangle[k]];
        bool same = k > 0 && triangle[k] == triangle[k - 1];
        if (!same) t = rsv_texture_triangle_of(scene, ref, corner);
        density[k] = same ? density[k - 1] : texel_density(scene, texture, &t, corner);
        to->u[k] = rsv_tame(t.u + p->u[k] * t.du[0] + p->v[k] * t.du[1]);
        to->v[k] = rsv_tame(t.v + p->u[k] * t.dv[0] + p->v[k] * t.dv[1]);
    }
    for (int k = 0; k < LANES; k++) {
        float texels = f_min(f_max(width[k] * width[k] * density[k], 1), 1e30f);
        float level = f_min(f_max(0.5f * rough_log2(texels), 0), last);
        int finer = (int)level;
        to->level[0][k] = finer;
        to->level[1][k] = finer + 1 < (int)last ? finer + 1 : (int)last;
        to->coarser[k] = level - (float)finer;
    }
}

static inline int floor_of(float x)
{
    int whole = (int)x;
    return whole - (x < (float)whole ? 1 : 0);
}

/// A coordinate moved into the picture, as it repeats.
static inline float wrapped_coordinate(float x, rsv_wrap wrap)
{
    if (wrap == RSV_WRAP_CLAMP) return f_min(f_max(x, 0), 1);
    if (wrap == RSV_WRAP_REPEAT) return x - (float)floor_of(x);
    float turn = x - 2 * (float)floor_of(0.5f * x);
    return turn > 1 ? 2 - turn : turn;
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

/// What a lane adds up: the corners that it lies between.
typedef struct texel_lanes {
    int index[4][LANES]; ///< of their first codes
    float weight[4][LANES];
} __attribute__((aligned(64))) texel_lanes;

/// Adds the colours of texels, times their weights: lane by lane, a whole texel at a time.
static inline void add_texels(
    const rsv_texture *texture, const texel_lanes *restrict from, rsv_float4 *restrict color)
{
    for (int k = 0; k < LANES; k++) {
        rsv_float4 sum = color[k];
        for (int corner = 0; corner < 4; corner++)
            sum += from->weight[corner][k] * texel_at(texture->unorm + from->index[corner][k]);
        color[k] = sum;
    }
}

/// Finds the texels of a level of the pyramid, and asks the memory for them. @param share of the level in the colour
static inline void find_level(const rsv_texture *texture, const texture_lanes *restrict at,
    const int *restrict level, const float *restrict share, texel_lanes *restrict to)
{
    _Alignas(64) int width[LANES], height[LANES], first[LANES], column[2][LANES], row[2][LANES];
    _Alignas(64) float across[LANES], down[LANES];
    for (int k = 0; k < LANES; k++) {
        const rsv_texture_level *l = &texture->level[level[k]];
        width[k] = (int)l->width, height[k] = (int)l->height, first[k] = (int)l->first;
    }
    find_texels(at->u, width, texture->wrap_u, column, across);
    find_texels(at->v, height, texture->wrap_v, row, down);
    for (int corner = 0; corner < 4; corner++) {
        int right = corner & 1, below = corner >> 1, channels = (int)texture->channel_count;
        for (int k = 0; k < LANES; k++) {
            int texel = first[k] + row[below][k] * width[k] + column[right][k];
            float weight =
                share[k] * (right ? across[k] : 1 - across[k]) * (below ? down[k] : 1 - down[k]);
            to->index[corner][k] = texel * channels;
            to->weight[corner][k] = weight * (1.0f / 65535);
        }
        for (int k = 0; k < LANES && !right; k++)
            __builtin_prefetch(texture->unorm + to->index[corner][k]);
    }
}

/// Whether add_texels knows how to read the texture.
static inline bool is_packed_texture(const rsv_scene_view *scene, const rsv_texture_ref *ref)
{
    const rsv_texture *t = &scene->texture[ref->texture];
    return scene->uv[ref->uv_set] && t->unorm && t->channel_count >= 3 && !t->nearest && !t->covers;
}

/// The texture's colours. @param color [3][LANES] out
static inline void look_texture_up(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const int *restrict triangle, const rsv_ray_packet *restrict p, const float *restrict width,
    float (*restrict color)[LANES])
{
    const rsv_texture *texture = &scene->texture[ref->texture];
    _Alignas(64) float finer[LANES];
    rsv_float4 sum[LANES];
    texel_lanes texels[2];
    texture_lanes at;
    find_texture_lanes(scene, ref, triangle, p, width, &at);
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < LANES; k++) {
        at.u[k] = wrapped_coordinate(at.u[k], texture->wrap_u);
        at.v[k] = wrapped_coordinate(at.v[k], texture->wrap_v);
        finer[k] = 1 - at.coarser[k];
    }
    bool both = any_positive(at.coarser);
    find_level(texture, &at, at.level[0], finer, &texels[0]);
    if (both) find_level(texture, &at, at.level[1], at.coarser, &texels[1]);
    add_texels(texture, &texels[0], sum);
    if (both) add_texels(texture, &texels[1], sum);
    for (int k = 0; k < LANES; k++)
        for (int c = 0; c < 3; c++)
            color[c][k] = sum[k][c];
}

/// The one texture that a material's base color varies by; NULL = several, or of an unusual kind.
static inline const rsv_texture_ref *packed_texture_of(
    const rsv_scene_view *scene, uint32_t material)
{
    const rsv_material *m = &scene->material[material];
    const rsv_texture_ref *found = NULL;
    for (size_t k = 0; k < m->texture_count; k++) {
        if (m->textures[k].role != RSV_TEXTURE_BASE_COLOR) continue;
        if (found || !is_packed_texture(scene, &m->textures[k])) return NULL;
        found = &m->textures[k];
    }
    return found;
}
