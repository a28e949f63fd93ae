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

/// Unit normals of the triangles, and those interpolated between their corners: on their fronts.
typedef struct front_normals {
    rsv_lanes3 geometric, shading;
} __attribute__((aligned(64))) front_normals;

/// rsv_surface_point_at, all lanes at once.
static inline void interpolate_normals(
    const rsv_ray_packet *restrict p, const rsv_lanes3 *restrict corner, front_normals *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float u = p->u[k], v = p->v[k], w = 1 - u - v;
        float gx = p->normal_x[k], gy = p->normal_y[k], gz = p->normal_z[k];
        float nx = w * corner[0][0][k] + u * corner[1][0][k] + v * corner[2][0][k];
        float ny = w * corner[0][1][k] + u * corner[1][1][k] + v * corner[2][1][k];
        float nz = w * corner[0][2][k] + u * corner[1][2][k] + v * corner[2][2][k];
        float gs = 1 / sqrtf(gx * gx + gy * gy + gz * gz);
        float ns = 1 / sqrtf(nx * nx + ny * ny + nz * nz);
        gx *= gs, gy *= gs, gz *= gs;
        nx *= ns, ny *= ns, nz *= ns;
        bool above = nx * gx + ny * gy + nz * gz > 0;
        to->geometric[0][k] = gx, to->geometric[1][k] = gy, to->geometric[2][k] = gz;
        to->shading[0][k] = above ? nx : gx;
        to->shading[1][k] = above ? ny : gy;
        to->shading[2][k] = above ? nz : gz;
    }
}

/// rsv_specular_bsdf_normal, all lanes at once.
static inline void find_normals(const rsv_ray_packet *restrict p,
    const front_normals *restrict front, glossy_lanes *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float dx = p->direction_x[k], dy = p->direction_y[k], dz = p->direction_z[k];
        float gx = front->geometric[0][k], gy = front->geometric[1][k], gz = front->geometric[2][k];
        float nx = front->shading[0][k], ny = front->shading[1][k], nz = front->shading[2][k];
        float side = gx * dx + gy * dy + gz * dz > 0 ? -1.0f : 1.0f;
        gx *= side, gy *= side, gz *= side;
        nx *= side, ny *= side, nz *= side;
        float cos = -(nx * dx + ny * dy + nz * dz), twice = 2 * cos;
        float mx = twice * nx + dx, my = twice * ny + dy, mz = twice * nz + dz;
        bool keeps = (cos > 0) & (mx * gx + my * gy + mz * gz > 0);
        to->normal[0][k] = keeps ? nx : gx;
        to->normal[1][k] = keeps ? ny : gy;
        to->normal[2][k] = keeps ? nz : gz;
        to->cos[k] = keeps ? cos : -(gx * dx + gy * dy + gz * dz);
    }
}

// ---- normal maps ----------------------------------------------------------------------------------

/// Tangents of the lanes' triangles, not yet at right angles to a normal, and the hands of their frames.
typedef struct tangent_lanes {
    rsv_lanes3 along;
    float hand[LANES]; ///< 0 = there is no frame
} __attribute__((aligned(64))) tangent_lanes;

/// As rsv_tangent_frame finds it. @return whether all points of the triangle have the same one
static inline bool set_tangent(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const rsv_ray_packet *restrict p, int triangle, int k, tangent_lanes *restrict to)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 tangent = v3(1, 0, 0);
    float hand = 0;
    bool varies = rsv_vertex_tangent(scene, corner, p->u[k], p->v[k], &tangent, &hand);
    if (!varies && !rsv_derived_tangent(scene, ref, corner, &tangent, &hand)) hand = 0;
    float scale = 1 / v3_max_abs(tangent);
    to->along[0][k] = tangent.x * scale;
    to->along[1][k] = tangent.y * scale;
    to->along[2][k] = tangent.z * scale;
    to->hand[k] = hand;
    return !varies;
}

static inline void find_tangents(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const rsv_ray_packet *restrict p, const int *restrict triangle, tangent_lanes *restrict to)
{
    bool same = false;
    for (int k = 0; k < LANES; k++) {
        if (k > 0 && same && triangle[k] == triangle[k - 1]) {
            for (int c = 0; c < 3; c++)
                to->along[c][k] = to->along[c][k - 1];
            to->hand[k] = to->hand[k - 1];
        } else {
            same = set_tangent(scene, ref, p, triangle[k], k, to);
        }
    }
}

/// rsv_normal_by_map, where the bent normal is above the triangle. @param texel [3][LANES]
static inline void bend_normals(const tangent_lanes *restrict tangent, float scale,
    float (*restrict texel)[LANES], const int *restrict requested, front_normals *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float nx = to->shading[0][k], ny = to->shading[1][k], nz = to->shading[2][k];
        float tx = tangent->along[0][k], ty = tangent->along[1][k], tz = tangent->along[2][k];
        float lean = tx * nx + ty * ny + tz * nz;
        tx -= lean * nx, ty -= lean * ny, tz -= lean * nz;
        float unit = 1 / sqrtf(tx * tx + ty * ty + tz * tz);
        tx *= unit, ty *= unit, tz *= unit;
        float bx = ny * tz - nz * ty, by = nz * tx - nx * tz, bz = nx * ty - ny * tx;
        float x = scale * (2 * texel[0][k] - 1),
              y = tangent->hand[k] * scale * (2 * texel[1][k] - 1);
        float z = 2 * texel[2][k] - 1;
        float mx = z * nx + x * tx + y * bx, my = z * ny + x * ty + y * by;
        float mz = z * nz + x * tz + y * bz;
        float length = sqrtf(mx * mx + my * my + mz * mz), turn = 1 / length;
        float above =
            mx * to->geometric[0][k] + my * to->geometric[1][k] + mz * to->geometric[2][k];
        bool bends = (requested[k] != 0) & (tangent->hand[k] != 0) & (length > 0) & (above > 0) &
                     (unit < INFINITY);
        to->shading[0][k] = bends ? mx * turn : nx;
        to->shading[1][k] = bends ? my * turn : ny;
        to->shading[2][k] = bends ? mz * turn : nz;
    }
}

// ---- tables ---------------------------------------------------------------------------------------

/// Constants of the materials of a packet, times their maps.
typedef struct glossy_constants {
    rsv_lanes3 color, emission;
    float metallic[LANES], roughness[LANES];
    float alpha[LANES]; ///< width of the narrowest lobe; 0 = it is smooth
    int even[LANES];
    bool varies; ///< some lane is of a material with several tables
} __attribute__((aligned(64))) glossy_constants;

/// Between two neighbouring rows, which lie side by side so that one line of the cache holds both.
static inline void blend_rows(const rsv_glossy_row *restrict row, float weight, float *restrict to)
{
    for (int c = 0; c < 8; c++)
        to[c] = row[0][c] + weight * (row[1][c] - row[0][c]);
}

/// Albedo of metal between two neighbouring rows. @param color its reflectance @param to [3] out
static inline void blend_metal(const rsv_glossy_metal_row *restrict row, float weight,
    const float *restrict color, float *restrict to)
{
    float term[3][4];
    for (int n = 0; n < 3; n++)
        for (int c = 0; c < 4; c++)
            term[n][c] = row[0][n][c] + weight * (row[1][n][c] - row[0][n][c]);
    for (int c = 0; c < 3; c++)
        to[c] = term[0][c] + color[c] * (term[1][c] + color[c] * term[2][c]);
}

/// A lane's entries in the tables of a material that varies. @param value [8] as in rsv_glossy_row, out
static inline void blend_tables(const rsv_glossy_material *m, const glossy_constants *restrict at,
    int k, int first, float weight, float *restrict value)
{
    rsv_table_place level = { 0, 0 };
    if (m->level_count > 1) level = rsv_table_place_at(at->roughness[k], m->level_count);
    int place = level.index * RSV_TABLE_COS + first;
    int next = m->level_count > 1 ? place + RSV_TABLE_COS : place;
    float rougher[8], metal[2][3];
    blend_rows(m->row + place, weight, value);
    blend_rows(m->row + next, weight, rougher);
    for (int c = 0; c < 8; c++)
        value[c] += level.weight * (rougher[c] - value[c]);
    if (!m->metal) return;
    const float color[3] = { at->color[0][k], at->color[1][k], at->color[2][k] };
    blend_metal(m->metal + place, weight, color, metal[0]);
    blend_metal(m->metal + next, weight, color, metal[1]);
    for (int c = 0; c < 3; c++) {
        float whole = metal[0][c] + level.weight * (metal[1][c] - metal[0][c]);
        value[c] *= 1 - at->metallic[k];
        value[4 + c] += at->metallic[k] * (whole - value[4 + c]);
    }
}

/// Entries of the materials' tables. @param value [8] as in rsv_glossy_row, out
static inline void find_rows(const rsv_glossy_material *materials, const glossy_lanes *restrict g,
    const glossy_constants *restrict constant, float (*restrict value)[LANES])
{
    _Alignas(64) float weight[LANES], between[LANES][8];
    _Alignas(64) int first[LANES];
    for (int k = 0; k < LANES; k++) {
        float x = sqrtf(f_min(f_max(g->cos[k], 0), 1)) * (RSV_TABLE_COS - 1);
        int i = (int)x;
        first[k] = i < RSV_TABLE_COS - 2 ? i : RSV_TABLE_COS - 2;
        weight[k] = x - (float)first[k];
    }
    for (int k = 0; k < LANES && !constant->varies; k++)
        blend_rows(materials[g->material[k]].row + first[k], weight[k], between[k]);
    for (int k = 0; k < LANES && constant->varies; k++)
        blend_tables(&materials[g->material[k]], constant, k, first[k], weight[k], between[k]);
    for (int c = 0; c < 8; c++)
        for (int k = 0; k < LANES; k++)
            value[c][k] = between[k][c];
}

/// Of one lane, in the lanes from `first` to before `end`.
static inline void set_constants(const rsv_glossy_shading *s, const rsv_glossy_material *m,
    int first, int end, glossy_constants *restrict to)
{
    for (int k = first; k < end; k++) {
        for (int c = 0; c < 3; c++) {
            to->color[c][k] = m->base_color[c];
            to->emission[c][k] = s->shows_emission ? m->emission[c] : 0;
        }
        to->metallic[k] = m->metallic;
        to->roughness[k] = m->roughness;
        to->alpha[k] = m->coat_alpha;
        to->even[k] = m->even;
    }
    to->varies |= rsv_glossy_is_general(m);
}

/// Lanes at surfaces of a material, a bit each.
static inline uint32_t lanes_of_material(const int *restrict materials, int material)
{
    uint32_t lanes = 0;
    for (int k = 0; k < LANES; k++)
        lanes |= (uint32_t)(materials[k] == material) << k;
    return lanes;
}

// ---- maps -----------------------------------------------------------------------------------------

/// The first map of a material that has any.
static inline int first_map(const rsv_glossy_material *m) { return __builtin_ctz(m->maps); }

/// Prefetches the texels of all maps that lie where those of the first one do.
static inline void approach_maps(
    const rsv_glossy_shading *s, const rsv_glossy_material *m, const rsv_texels_ahead *at)
{
    for (uint32_t left = m->alike; left; left &= left - 1) {
        const rsv_texture *texture = &s->view->texture[m->map[__builtin_ctz(left)].texture];
        approach_texels(texture, &at->level[0]);
        if (at->both) approach_texels(texture, &at->level[1]);
    }
}

/// Texels that lanes at surfaces of one material read.
static void find_texels_ahead(const rsv_glossy_shading *s, const rsv_ray_packet *restrict p,
    const float *restrict width, uint32_t lanes, rsv_texels_ahead *restrict to)
{
    _Alignas(64) int triangle[LANES], materials[LANES];
    to->lanes = 0;
    if (!lanes) return;
    fill_triangles(p, lanes, triangle);
    gather(s->view->triangle_material, triangle, materials);
    int material = materials[__builtin_ctz(lanes)];
    const rsv_glossy_material *m = &s->materials[material];
    if (!m->maps) return;
    to->lanes = lanes & lanes_of_material(materials, material);
    fill_triangles(p, to->lanes, triangle);
    find_texels_of(s->view, &m->map[first_map(m)], triangle, p, width, to);
    approach_maps(s, m, to);
}

/// A packet whose pixels have footprints.
typedef struct textured_packet {
    const rsv_ray_packet *rays;
    const float *width;            ///< [LANES] metres
    const rsv_texels_ahead *ahead; ///< NULL = none
} textured_packet;

/// What maps change.
typedef struct mapped_lanes {
    glossy_constants *constant;
    front_normals *normals;
} mapped_lanes;

/// One map of lanes at surfaces of one material.
typedef struct map_lanes {
    const rsv_glossy_shading *shading;
    const rsv_glossy_material *material;
    const rsv_ray_packet *rays;
    _Alignas(64) int triangle[LANES]; ///< one of the requested lanes' in the others
    _Alignas(64) int requested[LANES];
    _Alignas(64) float texel[3][LANES];
} map_lanes;

static inline void multiply_color(const map_lanes *restrict at, rsv_lanes3 color)
{
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < LANES; k++)
            color[c][k] *= at->requested[k] ? at->texel[c][k] : 1;
}

static inline void apply_map(map_lanes *restrict at, rsv_glossy_map map, mapped_lanes to)
{
    const rsv_texture_ref *ref = &at->material->map[map];
    tangent_lanes tangent;
    switch (map) {
    case RSV_GLOSSY_COLOR:
        multiply_color(at, to.constant->color);
        break;
    case RSV_GLOSSY_EMISSION:
        multiply_color(at, to.constant->emission);
        break;
    case RSV_GLOSSY_METALLIC_ROUGHNESS:
        for (int k = 0; k < LANES; k++) {
            to.constant->metallic[k] *= at->requested[k] ? at->texel[2][k] : 1;
            to.constant->roughness[k] *= at->requested[k] ? at->texel[1][k] : 1;
        }
        break;
    default:
        find_tangents(at->shading->view, ref, at->rays, at->triangle, &tangent);
        bend_normals(&tangent, ref->scale, at->texel, at->requested, to.normals);
    }
}

/// Applies the maps of lanes at surfaces of one material.
static inline void apply_maps(
    map_lanes *restrict at, textured_packet packet, uint32_t lanes, mapped_lanes to)
{
    const rsv_glossy_material *m = at->material;
    const rsv_scene_view *view = at->shading->view;
    rsv_texels_ahead own, other;
    const rsv_texels_ahead *first = packet.ahead;
    fill_triangles(packet.rays, lanes, at->triangle);
    for (int k = 0; k < LANES; k++)
        at->requested[k] = (int)(lanes >> k & 1);
    if (!first || first->lanes != lanes) {
        find_texels_of(view, &m->map[first_map(m)], at->triangle, packet.rays, packet.width, &own);
        first = &own;
    }
    for (uint32_t left = m->maps; left; left &= left - 1) {
        int map = __builtin_ctz(left);
        const rsv_texels_ahead *texels = first;
        if (!(m->alike >> map & 1)) {
            find_texels_of(view, &m->map[map], at->triangle, packet.rays, packet.width, &other);
            texels = &other;
        }
        read_texels(&view->texture[m->map[map].texture], texels, at->texel);
        apply_map(at, (rsv_glossy_map)map, to);
    }
}

/// Base colours of lanes whose textures are looked up one by one.
static inline void find_odd_colors(
    const rsv_glossy_shading *s, textured_packet packet, uint32_t lanes, rsv_lanes3 color)
{
    const rsv_ray_packet *restrict p = packet.rays;
    for (uint32_t left = lanes; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        rsv_rgb at = rsv_base_color_at(s->view, p->triangle[k], p->u[k], p->v[k], packet.width[k]);
        color[0][k] = at.r, color[1][k] = at.g, color[2][k] = at.b;
    }
}

/// Widths of lobes, once roughnesses are known.
static inline void finish_constants(glossy_constants *restrict to)
{
    for (int k = 0; k < LANES; k++) {
        float alpha = to->roughness[k] * to->roughness[k], coat = to->alpha[k];
        bool rough = to->roughness[k] >= RSV_GLOSSY_EVEN_ROUGHNESS;
        to->even[k] &= rough & (to->metallic[k] == 0);
        alpha = alpha < coat ? alpha : coat;
        to->alpha[k] = alpha < RSV_SMOOTH_ALPHA ? 0 : alpha;
    }
}

static inline void find_constants(const rsv_glossy_shading *s, textured_packet packet,
    uint32_t lanes, const glossy_lanes *restrict g, mapped_lanes to)
{
    bool alike = all_equal(g->material);
    to.constant->varies = false;
    if (alike) set_constants(s, &s->materials[g->material[0]], 0, LANES, to.constant);
    for (int k = 0; k < LANES && !alike; k++)
        set_constants(s, &s->materials[g->material[k]], k, k + 1, to.constant);
    for (uint32_t left = lanes; left;) {
        int material = g->material[__builtin_ctz(left)];
        uint32_t same = lanes_of_material(g->material, material) & left;
        const rsv_glossy_material *m = &s->materials[material];
        left &= ~same;
        map_lanes maps = { .shading = s, .material = m, .rays = packet.rays };
        if (m->maps) apply_maps(&maps, packet, same, to);
        if (m->odd_color) find_odd_colors(s, packet, same, to.constant->color);
    }
    finish_constants(to.constant);
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

/// Lanes of some whose lobe is smooth.
static inline uint32_t smooth_lanes(const glossy_constants *restrict constant, uint32_t lanes)
{
    uint32_t smooth = 0;
    for (int k = 0; k < LANES; k++)
        smooth |= (uint32_t)(constant->alpha[k] == 0) << k;
    return smooth & lanes;
}

static uint32_t shade_glossy_packet(const rsv_glossy_shading *s, const rsv_ray_packet *restrict p,
    const float *restrict width, uint32_t lanes, float (*restrict radiance)[4],
    rsv_glossy_block block)
{
    _Alignas(64) int triangle[LANES];
    lobe_lanes lobes;
    _Alignas(64) rsv_lanes3 corner[3];
    glossy_constants constant;
    front_normals normals;
    glossy_lanes g;
    fill_triangles(p, lanes, triangle);
    gather(s->view->triangle_material, triangle, g.material);
    gather_normals(s->view, triangle, corner);
    interpolate_normals(p, corner, &normals);
    const textured_packet packet = { p, width, block.ahead };
    find_constants(s, packet, lanes, &g, (mapped_lanes){ &constant, &normals });
    find_normals(p, &normals, &g);
    find_rows(s->materials, &g, &constant, lobes.value);
    uint32_t smooth = smooth_lanes(&constant, lanes);
    show_bases(p, lanes & ~smooth, &constant, &lobes, radiance);
    if (any_positive(lobes.depth)) note_lobes(p, &g, &constant, &lobes, block);
    return smooth;
}
