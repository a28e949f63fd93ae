/// Included once per instruction set, with RSV_KERNELS the name of its table.
#include "../render/camera_step.h"
#include "packet_kernels.h"

#include <string.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define LANES RSV_PACKET_WIDTH

/// One word per lane. Where there is no fast instruction for it, lane by lane.
/// @param index in words @param word [LANES] of 4 bytes each, 64-byte aligned
static inline void gather(const void *base, const int *restrict index, void *restrict word)
{
#if defined(__AVX512F__)
    _mm512_store_epi32(word, _mm512_i32gather_epi32(_mm512_load_epi32(index), base, 4));
#else
    for (int k = 0; k < LANES; k++)
        memcpy((char *)word + 4 * k, (const char *)base + 4 * (size_t)(uint32_t)index[k], 4);
#endif
}

/// Lanes whose word is not 0, a bit each.
static inline uint32_t lanes_set(const int *restrict word)
{
#if defined(__AVX512F__)
    __m512i words = _mm512_load_epi32(word);
    return _mm512_test_epi32_mask(words, words);
#else
    uint32_t set = 0;
    for (int k = 0; k < LANES; k++)
        set |= (uint32_t)(word[k] != 0) << k;
    return set;
#endif
}

/// Whether all lanes hold the same word: most packets see one triangle.
static inline bool all_equal(const int *restrict word)
{
    int difference = 0;
    for (int k = 0; k < LANES; k++)
        difference |= word[k] ^ word[0];
    return difference == 0;
}

_Static_assert(sizeof(rsv_shown_side) == 8, "as gathered");

static void aim_packet(
    const rsv_frame_aim *restrict a, uint32_t column, uint32_t row, rsv_ray_packet *restrict p)
{
    const rsv_lens *lens = &a->lens;
    const rsv_camera *c = &lens->camera;
    bool orthographic = c->vertical_fov == 0;
    for (int k = 0; k < LANES; k++) {
        // the arithmetic of rsv_lens_ray
        int i = (int)column + k % RSV_BLOCK, j = (int)row + k / RSV_BLOCK;
        float place_x = rsv_scatter(a->place_x, a->scatter, a->phase[0], (uint32_t)i, (uint32_t)j);
        float place_y = rsv_scatter(a->place_y, a->scatter, a->phase[1], (uint32_t)j, (uint32_t)i);
        float across = ((float)i + place_x - lens->half_width) * lens->pixel_size;
        float upwards = (lens->half_height - ((float)j + place_y)) * lens->pixel_size;
        float x = c->right.x * across + upwards * c->up.x;
        float y = c->right.y * across + upwards * c->up.y;
        float z = c->right.z * across + upwards * c->up.z;
        float dx = c->forward.x + x, dy = c->forward.y + y, dz = c->forward.z + z;
        float scale = 1 / sqrtf(dx * dx + dy * dy + dz * dz);
        p->origin_x[k] = orthographic ? c->position.x + x : c->position.x;
        p->origin_y[k] = orthographic ? c->position.y + y : c->position.y;
        p->origin_z[k] = orthographic ? c->position.z + z : c->position.z;
        p->direction_x[k] = orthographic ? c->forward.x : dx * scale;
        p->direction_y[k] = orthographic ? c->forward.y : dy * scale;
        p->direction_z[k] = orthographic ? c->forward.z : dz * scale;
        bool inside = (i < (int)a->width) & (j < (int)a->height);
        p->t_max[k] = inside ? INFINITY : -1;
    }
}

/// Sides that the rays met, lane by lane. @return lanes whose side is not RSV_SHOWN_STORED
static inline uint32_t find_sides(const rsv_light_table *restrict table,
    const rsv_ray_packet *restrict p, int *restrict first_cell, int *restrict level)
{
    _Alignas(64) int index[LANES], kind[LANES];
    const rsv_shown_side *sides = table->side[0];
    uint32_t none = table->triangle_count;
    for (int k = 0; k < LANES; k++) { // rsv_shown_side_of
        uint32_t triangle = p->triangle[k] < none ? p->triangle[k] : none;
        index[k] = 2 * (int)(2 * triangle + (rsv_packet_meets_back(p, (uint32_t)k) ? 1 : 0));
    }
    if (all_equal(index)) {
        const rsv_shown_side side = sides[index[0] / 2];
        for (int k = 0; k < LANES; k++) {
            first_cell[k] = (int)side.cell;
            level[k] = side.level;
        }
        return side.kind == RSV_SHOWN_STORED ? 0 : (1u << LANES) - 1;
    }
    gather(&sides->cell, index, first_cell);
    gather(&sides->level, index, kind);
    for (int k = 0; k < LANES; k++) {
        level[k] = kind[k] & 0xffff;
        kind[k] = (kind[k] >> 16) - RSV_SHOWN_STORED;
    }
    return lanes_set(kind);
}

static void approach_packet(const rsv_light_table *restrict table, const rsv_ray_packet *restrict p)
{
    int count = all_equal((const int *)p->triangle) ? 1 : LANES;
    for (int k = 0; k < count; k++)
        __builtin_prefetch(rsv_shown_side_of(table, p->triangle[k], false));
}

/// rsv_place_in_grid, in a form that vectorises.
static uint32_t locate_packet(const rsv_light_table *restrict table,
    const rsv_ray_packet *restrict p, rsv_packet_places *restrict at)
{
    _Alignas(64) int level[LANES];
    uint32_t left = find_sides(table, p, at->cell, level);
    for (int k = 0; k < LANES; k++) {
        int cells = 1 << level[k], last = cells - 1;
        float x = p->u[k] * (float)cells, y = p->v[k] * (float)cells;
        int i = (int)x, j = (int)y;
        j = j < 0 ? 0 : j;
        j = j > last ? last : j;
        i = i < 0 ? 0 : i;
        i = i > last - j ? last - j : i;
        float fx = x - (float)i, fy = y - (float)j;
        int flipped = (fx + fy > 1 ? 1 : 0) & (i + j < last ? 1 : 0);
        at->cell[k] += j * (cells + cells - j) + i + i + flipped;
        at->b0[k] = f_min(f_max(flipped ? fx + fy - 1 : 1 - fx - fy, 0), 1);
        at->b1[k] = f_min(f_max(flipped ? 1 - fx : fx, 0), 1 - at->b0[k]);
        at->b2[k] = 1 - at->b0[k] - at->b1[k];
    }
    for (int k = 0; k < LANES; k++)
        __builtin_prefetch(&table->child[at->cell[k]]);
    return left;
}

/// rsv_descend, all lanes at once.
static void descend_packet(const rsv_light_table *restrict table, rsv_packet_places *restrict at)
{
    _Alignas(64) int child[LANES];
    for (;;) {
        gather(table->child, at->cell, child);
        if (!lanes_set(child)) break;
        for (int k = 0; k < LANES; k++) {
            float b0 = 2 * at->b0[k], b1 = 2 * at->b1[k], b2 = 2 * at->b2[k];
            int part = b0 >= 1 ? 0 : b1 >= 1 ? 1 : b2 >= 1 ? 2 : 3;
            float c0 = part == 3 ? 1 - b0 : part == 0 ? b0 - 1 : b0;
            float c1 = part == 3 ? 1 - b1 : part == 1 ? b1 - 1 : b1;
            float c2 = part == 3 ? 1 - b2 : part == 2 ? b2 - 1 : b2;
            bool split = child[k] != 0;
            at->cell[k] = split ? child[k] + part : at->cell[k];
            at->b0[k] = split ? c0 : at->b0[k];
            at->b1[k] = split ? c1 : at->b1[k];
            at->b2[k] = split ? c2 : at->b2[k];
        }
    }
    for (int k = 0; k < LANES; k++) { // a cell may lie across two lines of the cache
        __builtin_prefetch(table->cell[at->cell[k]].corner[0]);
        __builtin_prefetch(table->cell[at->cell[k]].corner[2]);
    }
}

static void look_up_packet(const rsv_light_table *restrict table,
    const rsv_packet_places *restrict at, float (*restrict radiance)[4])
{
    for (int y = 0; y < RSV_BLOCK; y++) {
        rsv_float4 *out = (rsv_float4 *)radiance[y * RSV_TILE];
        for (int x = 0; x < RSV_BLOCK; x++)
            out[x] =
                rsv_light_in_cell(table->cell, rsv_packet_place(at, (uint32_t)(y * RSV_BLOCK + x)));
    }
}

/// rsv_srgb_octaves of a row.
static inline void find_octaves(const float *restrict shown, float *restrict octave)
{
    const float *table = rsv_srgb_octaves();
#if defined(__AVX512F__)
    const __m512 octaves = _mm512_loadu_ps(table);
    for (int k = 0; k < 4 * RSV_TILE; k += 16) {
        __m512i place = _mm512_srli_epi32(_mm512_castps_si512(_mm512_load_ps(shown + k)), 23);
        _mm512_store_ps(octave + k, _mm512_permutexvar_ps(place, octaves));
    }
#elif defined(__AVX2__)
    const __m256 first = _mm256_loadu_ps(table), last = _mm256_loadu_ps(table + 8);
    for (int k = 0; k < 4 * RSV_TILE; k += 8) {
        __m256i place = _mm256_srli_epi32(_mm256_castps_si256(_mm256_load_ps(shown + k)), 23);
        __m256 low = _mm256_permutevar8x32_ps(first, place);
        __m256 high = _mm256_permutevar8x32_ps(last, place);
        __m256 upper = _mm256_castsi256_ps(_mm256_slli_epi32(place, 28)); // bit 3 is the sign
        _mm256_store_ps(octave + k, _mm256_blendv_ps(low, high, upper));
    }
#else
    for (int k = 0; k < 4 * RSV_TILE; k++)
        octave[k] = table[rsv_srgb_octave_of(shown[k])];
#endif
}

/// Compiled once for each choice of `first` and `soft`. @param shown out [4 * RSV_TILE]
static inline __attribute__((always_inline)) void add_and_show(bool first, bool soft, float scale,
    const float *restrict in, float *restrict total, float *restrict shown)
{
    for (int k = 0; k < 4 * RSV_TILE; k++) {
        float sum = first ? in[k] : total[k] + in[k];
        if (!first) total[k] = sum;
        shown[k] = rsv_tone_shown(sum * scale, soft);
    }
}

/// @param code out [4 * RSV_TILE]
static inline void find_codes(const float *restrict shown, uint8_t *restrict code)
{
    _Alignas(64) float octave[4 * RSV_TILE];
    _Alignas(64) int word[4 * RSV_TILE];
    find_octaves(shown, octave);
    for (int k = 0; k < 4 * RSV_TILE; k++)
        word[k] = (int)(rsv_srgb_code(shown[k], octave[k]) + 0.5f);
    for (int k = 0; k < 4 * RSV_TILE; k++)
        code[k] = (uint8_t)(k % 4 == 3 ? 255 : word[k]);
}

/// First sums, written past the caches, because nothing reads them while the camera moves.
static void begin_sums(const float *restrict in, float *restrict total)
{
#if defined(__SSE2__)
    for (uint32_t k = 0; k < 4 * RSV_TILE; k += 4)
        _mm_stream_ps(total + k, _mm_load_ps(in + k));
#else
    memcpy(total, in, 4 * RSV_TILE * sizeof *in);
#endif
}

static void display_row(const rsv_frame_tone *tone, const float (*restrict radiance)[4],
    float (*restrict sum)[4], uint32_t count, uint8_t (*restrict pixel)[4])
{
    _Alignas(64) float shown[4 * RSV_TILE];
    _Alignas(64) uint8_t code[4 * RSV_TILE];
    const float *in = radiance[0];
    float *total = sum[0];
    if (tone->first && tone->soft)
        add_and_show(true, true, tone->scale, in, total, shown);
    else if (tone->first)
        add_and_show(true, false, tone->scale, in, total, shown);
    else
        add_and_show(false, tone->soft, tone->scale, in, total, shown);
    find_codes(shown, code);
    if (tone->first) begin_sums(in, total);
    if (count == RSV_TILE)
        memcpy(pixel, code, sizeof code);
    else
        memcpy(pixel, code, 4 * count);
}

#include "beam_kernels_body.h"
#include "glossy_filter_body.h"
#include "glossy_kernels_body.h"
#include "history_kernels_body.h"
#include "sky_kernels_body.h"
#include "smooth_kernels_body.h"

const rsv_packet_kernels RSV_KERNELS = { aim_packet, gather_beam, meet_packet, approach_packet,
    locate_packet, descend_packet, look_up_packet, show_sky_packet, find_texels_ahead,
    shade_glossy_packet, fill_cells, find_highlights, pack_pixels, blend_cells, smooth_cells,
    light_pixels, display_row, recall_row, leave_smooth_packet };
