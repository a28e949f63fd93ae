/// Sixteen pixels of glossy surfaces, included by packet_kernels_body.h.
#include "texture_kernels_body.h"

/// Hits of a packet's rays: materials, and shading normals.
typedef struct glossy_lanes {
    int material[LANES];
    rsv_lanes3 normal;
    float cos[LANES];
} __attribute__((aligned(64))) glossy_lanes;

/// Triangles of the requested lanes, with one of them repeated in the others.
static inline void fill_triangles(
    const rsv_ray_packet *restrict p, uint32_t lanes, int *restrict triangle)
{
    int some = (int)p->triangle[__builtin_ctz(lanes)];
    for (int k = 0; k < LANES; k++)
        triangle[k] = lanes >> k & 1 ? (int)p->triangle[k] : some;
}

/// Normals of the vertices of a packet's triangles.
static inline void gather_normals(
    const rsv_scene_view *view, const int *restrict triangle, rsv_lanes3 normal[3])
{
    _Alignas(64) int index[LANES], vertex[LANES], word[LANES];
    if (all_equal(triangle)) {
        for (int c = 0; c < 3; c++) {
            const rsv_vec3 n = view->normal[view->triangle[triangle[0]][c]];
            for (int k = 0; k < LANES; k++)
                normal[c][0][k] = n.x, normal[c][1][k] = n.y, normal[c][2][k] = n.z;
        }
        return;
    }
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < LANES; k++)
            index[k] = 3 * triangle[k] + c;
        gather(view->triangle, index, vertex);
        for (int axis = 0; axis < 3; axis++) {
            for (int k = 0; k < LANES; k++)
                index[k] = 3 * vertex[k] + axis;
            gather(view->normal, index, word);
            memcpy(normal[c][axis], word, sizeof word);
        }
    }
}

/// rsv_surface_point_at and rsv_specular_bsdf_normal, all lanes at once.
static inline void find_normals(
    const rsv_ray_packet *restrict p, const rsv_lanes3 *restrict corner, glossy_lanes *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float u = p->u[k], v = p->v[k], w = 1 - u - v;
        float gx = p->normal_x[k], gy = p->normal_y[k], gz = p->normal_z[k];
        float dx = p->direction_x[k], dy = p->direction_y[k], dz = p->direction_z[k];
        float nx = w * corner[0][0][k] + u * corner[1][0][k] + v * corner[2][0][k];
        float ny = w * corner[0][1][k] + u * corner[1][1][k] + v * corner[2][1][k];
        float nz = w * corner[0][2][k] + u * corner[1][2][k] + v * corner[2][2][k];
        float side = gx * dx + gy * dy + gz * dz > 0 ? -1.0f : 1.0f;
        float gs = side / sqrtf(gx * gx + gy * gy + gz * gz);
        float ns = side / sqrtf(nx * nx + ny * ny + nz * nz);
        gx *= gs, gy *= gs, gz *= gs;
        nx *= ns, ny *= ns, nz *= ns;
        float cos = -(nx * dx + ny * dy + nz * dz), twice = 2 * cos;
        float mx = twice * nx + dx, my = twice * ny + dy, mz = twice * nz + dz;
        bool keeps =
            (nx * gx + ny * gy + nz * gz > 0) & (cos > 0) & (mx * gx + my * gy + mz * gz > 0);
        to->normal[0][k] = keeps ? nx : gx;
        to->normal[1][k] = keeps ? ny : gy;
        to->normal[2][k] = keeps ? nz : gz;
        to->cos[k] = keeps ? cos : -(gx * dx + gy * dy + gz * dz);
    }
}

/// Rows of the materials' tables: two neighbours lie side by side, so that one line of the cache holds both.
/// @param value [8] as in rsv_glossy_row, out
static inline void find_rows(const rsv_glossy_material *materials, const glossy_lanes *restrict g,
    float (*restrict value)[LANES])
{
    _Alignas(64) float weight[LANES], between[LANES][8];
    _Alignas(64) int first[LANES];
    for (int k = 0; k < LANES; k++) {
        float x = sqrtf(f_min(f_max(g->cos[k], 0), 1)) * (RSV_TABLE_COS - 1);
        int i = (int)x;
        first[k] = i < RSV_TABLE_COS - 2 ? i : RSV_TABLE_COS - 2;
        weight[k] = x - (float)first[k];
    }
    for (int k = 0; k < LANES; k++) {
        const rsv_glossy_row *row = &materials[g->material[k]].row[first[k]];
        for (int c = 0; c < 8; c++)
            between[k][c] = row[0][c] + weight[k] * (row[1][c] - row[0][c]);
    }
    for (int c = 0; c < 8; c++)
        for (int k = 0; k < LANES; k++)
            value[c][k] = between[k][c];
}

/// Constants of the materials of a packet.
typedef struct glossy_constants {
    rsv_lanes3 color, emission;
    float alpha[LANES];
    int even[LANES];
} __attribute__((aligned(64))) glossy_constants;

/// Of one lane, in the lanes from `first` to before `end`.
static inline void set_constants(const rsv_glossy_shading *s, const rsv_glossy_material *m,
    int first, int end, glossy_constants *restrict to)
{
    for (int k = first; k < end; k++) {
        for (int c = 0; c < 3; c++) {
            to->color[c][k] = m->base_color[c];
            to->emission[c][k] = s->shows_emission ? m->emission[c] : 0;
        }
        to->alpha[k] = m->alpha;
        to->even[k] = m->even;
    }
}

/// Lanes at surfaces of a material, a bit each.
static inline uint32_t lanes_of_material(const int *restrict materials, int material)
{
    uint32_t lanes = 0;
    for (int k = 0; k < LANES; k++)
        lanes |= (uint32_t)(materials[k] == material) << k;
    return lanes;
}

/// Texels that lanes at surfaces of one material read, unless these are not packed.
static void find_texels_ahead(const rsv_glossy_shading *s, const rsv_ray_packet *restrict p,
    const float *restrict width, uint32_t lanes, rsv_texels_ahead *restrict to)
{
    _Alignas(64) int triangle[LANES], materials[LANES];
    to->lanes = 0;
    if (!lanes) return;
    fill_triangles(p, lanes, triangle);
    gather(s->view->triangle_material, triangle, materials);
    int material = materials[__builtin_ctz(lanes)];
    if (!s->materials[material].texture_count) return;
    const rsv_texture_ref *ref = packed_texture_of(s->view, (uint32_t)material);
    if (!ref) return;
    to->lanes = lanes & lanes_of_material(materials, material);
    fill_triangles(p, to->lanes, triangle);
    find_texels_of(s->view, ref, triangle, p, width, to);
}

/// A packet whose pixels have footprints.
typedef struct textured_packet {
    const rsv_ray_packet *rays;
    const float *width;            ///< [LANES] metres
    const rsv_texels_ahead *ahead; ///< NULL = none
} textured_packet;

/// Base colors of lanes at surfaces of one material with textures.
static inline void find_colors(const rsv_glossy_shading *s, textured_packet packet, uint32_t lanes,
    uint32_t material, glossy_constants *restrict to)
{
    _Alignas(64) float color[3][LANES];
    _Alignas(64) int triangle[LANES];
    const rsv_ray_packet *restrict p = packet.rays;
    const rsv_texture_ref *ref = packed_texture_of(s->view, material);
    if (ref) {
        rsv_texels_ahead now;
        const rsv_texels_ahead *texels = packet.ahead;
        if (!texels || texels->lanes != lanes) {
            fill_triangles(p, lanes, triangle);
            find_texels_of(s->view, ref, triangle, p, packet.width, &now);
            texels = &now;
        }
        read_texels(&s->view->texture[ref->texture], texels, color);
        for (int k = 0; k < LANES; k++)
            for (int c = 0; c < 3; c++)
                to->color[c][k] *= lanes >> k & 1 ? color[c][k] : 1;
        return;
    }
    for (uint32_t left = lanes; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        rsv_rgb at = rsv_base_color_at(s->view, p->triangle[k], p->u[k], p->v[k], packet.width[k]);
        to->color[0][k] = at.r, to->color[1][k] = at.g, to->color[2][k] = at.b;
    }
}

static inline void find_constants(const rsv_glossy_shading *s, textured_packet packet,
    uint32_t lanes, const glossy_lanes *restrict g, glossy_constants *restrict to)
{
    bool alike = all_equal(g->material);
    if (alike) set_constants(s, &s->materials[g->material[0]], 0, LANES, to);
    for (int k = 0; k < LANES && !alike; k++)
        set_constants(s, &s->materials[g->material[k]], k, k + 1, to);
    for (uint32_t left = lanes; left;) {
        int material = g->material[__builtin_ctz(left)];
        uint32_t same = lanes_of_material(g->material, material) & left;
        left &= ~same;
        if (s->materials[material].texture_count)
            find_colors(s, packet, same, (uint32_t)material, to);
    }
}

/// Four rows of a block from lanes.
static inline void put_block(const float *restrict lanes, float *restrict plane)
{
    for (int row = 0; row < RSV_BLOCK; row++)
        memcpy(plane + row * RSV_TILE, lanes + row * RSV_BLOCK, RSV_BLOCK * sizeof *lanes);
}

/// Lobes that may remain to be lit.
typedef struct lobe_lanes {
    float value[8][LANES]; ///< of the tables of their materials
    float mean[3][LANES];  ///< radiance that arrives
    float depth[LANES];    ///< 0 = none is left
} __attribute__((aligned(64))) lobe_lanes;

/// Records the lobes that remain to be lit.
static inline void note_lobes(const rsv_ray_packet *restrict p, const glossy_lanes *restrict g,
    const glossy_constants *restrict constant, const lobe_lanes *restrict lobes,
    rsv_glossy_block block)
{
    rsv_glossy_tile *restrict tile = block.tile;
    uint32_t first = block.first;
    _Alignas(64) float one[LANES];
    for (int k = 0; k < LANES; k++)
        one[k] = 1;
    put_block(lobes->depth, tile->depth + first);
    put_block(constant->alpha, tile->alpha + first);
    put_block(p->u, tile->u + first);
    put_block(p->v, tile->v + first);
    for (int c = 0; c < 3; c++) {
        put_block(g->normal[c], tile->normal[c] + first);
        put_block(lobes->value[4 + c], tile->albedo[c] + first);
        put_block(lobes->mean[c], tile->even[c] + first);
        put_block(one, tile->passed[c] + first);
    }
    for (int row = 0; row < RSV_BLOCK; row++)
        memcpy(tile->triangle + first + row * RSV_TILE, p->triangle + row * RSV_BLOCK,
            RSV_BLOCK * sizeof *tile->triangle);
    tile->count++;
}

/// One channel of the lanes' light: base and isotropic lobes.
/// @param channel irradiance in, radiance out, where `glossy` is not 0
static inline void show_channel(int c, const int *restrict glossy,
    const glossy_constants *restrict constant, lobe_lanes *restrict lobes, float *restrict channel)
{
    const float *color = constant->color[c], *emission = constant->emission[c];
    const float *base = lobes->value[c], *lobe = lobes->value[4 + c];
    for (int k = 0; k < LANES; k++) {
        float mean = channel[k] * (1 / RSV_PI), left = constant->even[k] ? lobe[k] : 0;
        float share = color[k] * base[k] + left, shown = emission[k] + mean * share;
        lobes->mean[c][k] = mean;
        channel[k] = glossy[k] ? shown : channel[k];
    }
}

/// Light of lanes without the lobes that remain to be lit. @param radiance of their block, in and out
static inline void show_bases(const rsv_ray_packet *restrict p, uint32_t lanes,
    const glossy_constants *restrict constant, lobe_lanes *restrict lobes,
    float (*restrict radiance)[4])
{
    _Alignas(64) float shown[4 * LANES], channel[4][LANES];
    _Alignas(64) int glossy[LANES];
    for (int row = 0; row < RSV_BLOCK; row++)
        memcpy(
            shown + 4 * RSV_BLOCK * row, radiance[row * RSV_TILE], 4 * RSV_BLOCK * sizeof *shown);
    for (int k = 0; k < LANES; k++) {
        glossy[k] = (int)(lanes >> k & 1);
        lobes->depth[k] = glossy[k] & ~constant->even[k] ? p->t_max[k] : 0;
    }
    for (int k = 0; k < LANES; k++) {
        channel[0][k] = shown[4 * k], channel[1][k] = shown[4 * k + 1];
        channel[2][k] = shown[4 * k + 2], channel[3][k] = shown[4 * k + 3];
    }
    for (int c = 0; c < 3; c++)
        show_channel(c, glossy, constant, lobes, channel[c]);
    for (int k = 0; k < LANES; k++) {
        shown[4 * k] = channel[0][k], shown[4 * k + 1] = channel[1][k];
        shown[4 * k + 2] = channel[2][k], shown[4 * k + 3] = channel[3][k];
    }
    for (int row = 0; row < RSV_BLOCK; row++)
        memcpy(
            radiance[row * RSV_TILE], shown + 4 * RSV_BLOCK * row, 4 * RSV_BLOCK * sizeof *shown);
}

static void shade_glossy_packet(const rsv_glossy_shading *s, const rsv_ray_packet *restrict p,
    const float *restrict width, uint32_t lanes, float (*restrict radiance)[4],
    rsv_glossy_block block)
{
    _Alignas(64) int triangle[LANES];
    lobe_lanes lobes;
    _Alignas(64) rsv_lanes3 corner[3];
    glossy_constants constant;
    glossy_lanes g;
    fill_triangles(p, lanes, triangle);
    gather(s->view->triangle_material, triangle, g.material);
    gather_normals(s->view, triangle, corner);
    find_normals(p, corner, &g);
    find_rows(s->materials, &g, lobes.value);
    find_constants(s, (textured_packet){ p, width, block.ahead }, lanes, &g, &constant);
    show_bases(p, lanes, &constant, &lobes, radiance);
    if (any_positive(lobes.depth)) note_lobes(p, &g, &constant, &lobes, block);
}
