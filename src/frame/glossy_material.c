#include "glossy_material.h"

#include "../core/core.h"
#include "../scene/material_at.h"
#include "../scene/texture.h"

#include <string.h>

// ---- albedo -------------------------------------------------------------------------------------

/// Lower limit of divisors.
#define LEAST_ALBEDO 1e-3f

static rsv_rgb metal_albedo(const rsv_bsdf *b, float cos)
{
    rsv_rgb once = rsv_bsdf_metal(b, f_min(f_max(cos, 0), 1));
    if (b->alpha == 0) return once;
    float missing = rsv_bsdf_missing(b, false, 0, cos);
    return rgb_mad(rgb_scale(once, 1 - missing), missing, rsv_bsdf_metal_again(b));
}

static rsv_rgb at_least(rsv_rgb a)
{
    return rgb(f_max(a.r, LEAST_ALBEDO), f_max(a.g, LEAST_ALBEDO), f_max(a.b, LEAST_ALBEDO));
}

rsv_rgb rsv_glossy_albedo(const rsv_bsdf *b, float cos)
{
    rsv_rgb sum = rgb_gray(0);
    if (b->metallic > 0) sum = rgb_mad(sum, b->metallic, metal_albedo(b, cos));
    if (b->coated && b->metallic < 1)
        sum = rgb_mad(sum, 1 - b->metallic, rsv_bsdf_coat_albedo(b, cos));
    if (b->transmission > 0) sum = rgb_mad(sum, (1 - b->metallic) * b->transmission, rgb_gray(1));
    if (b->passed > 0) sum = rgb_mad(sum, b->passed, b->passed_color);
    if (!b->layered) return at_least(sum);
    sum = rgb_mul(sum, rsv_bsdf_passage(b, cos).light);
    sum = rgb_add(sum, rgb_gray(rsv_bsdf_clearcoat_albedo(b, cos)));
    rsv_wide_layers wide = rsv_bsdf_wide_layers(b, cos);
    return at_least(rgb_add(sum, rsv_wide_layers_albedo(&wide)));
}

float rsv_glossy_width(const rsv_bsdf *b)
{
    float width = b->alpha > 0 ? b->alpha : 1;
    if (b->clearcoat > 0 && b->clearcoat_alpha > 0) width = f_min(width, b->clearcoat_alpha);
    return width;
}

// ---- which are plain ------------------------------------------------------------------------------

static int map_of_role(rsv_texture_role role)
{
    switch (role) {
    case RSV_TEXTURE_BASE_COLOR:
        return RSV_GLOSSY_COLOR;
    case RSV_TEXTURE_METALLIC_ROUGHNESS:
        return RSV_GLOSSY_METALLIC_ROUGHNESS;
    case RSV_TEXTURE_NORMAL:
        return RSV_GLOSSY_NORMAL;
    case RSV_TEXTURE_EMISSION:
        return RSV_GLOSSY_EMISSION;
    default:
        return RSV_GLOSSY_MAPS;
    }
}

/// Whether texels are looked up sixteen at a time (texture_kernels_body.h).
static bool is_packed(const rsv_scene_view *scene, const rsv_texture_ref *ref)
{
    const rsv_texture *t = &scene->texture[ref->texture];
    return scene->uv[ref->uv_set] && t->unorm && t->channel_count >= 3 && !t->nearest && !t->covers;
}

/// Whether every texture is a map, cuts the surface out, or gives the base colour in some other way.
static bool has_plain_textures(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_material *m = &scene->view->material[material];
    bool found[RSV_GLOSSY_MAPS + 1] = { false };
    if (scene->view->material_varies[material] & ~RSV_VARIES_BY_TEXTURE) return false;
    for (size_t k = 0; k < m->texture_count; k++) {
        int map = map_of_role(m->textures[k].role);
        bool cover = m->textures[k].role == RSV_TEXTURE_OPACITY && m->alpha_cutoff > 0;
        bool once = map < RSV_GLOSSY_MAPS && !found[map] && is_packed(scene->view, &m->textures[k]);
        if (map != RSV_GLOSSY_COLOR && !cover && !once) return false;
        // metal's colour is not looked up one by one
        if (map == RSV_GLOSSY_COLOR && !once && m->metallic > 0) return false;
        found[map] = true;
    }
    return true;
}

/// Whether all lobes but the diffuse one are rough and reflect or refract about one normal.
static bool has_plain_lobes(const rsv_bsdf *b)
{
    bool smooth_coat = b->clearcoat > 0 && b->clearcoat_alpha == 0;
    return b->alpha > 0 && !smooth_coat && !b->tilted;
}

static bool is_plain(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_bsdf *b = &scene->bsdf[material];
    bool covers = scene->view->material[material].alpha_cutoff > 0 || b->opacity >= 1;
    if (b->unlit || rsv_hides_emission(b)) return false;
    return has_plain_lobes(b) && covers && has_plain_textures(scene, material);
}

static bool may_be_glossy(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_material *m = &scene->view->material[material];
    bool glossy = scene->bsdf[material].rough;
    for (size_t k = 0; k < m->texture_count; k++) {
        rsv_texture_role role = m->textures[k].role;
        glossy |= role != RSV_TEXTURE_BASE_COLOR && role != RSV_TEXTURE_OPACITY &&
                  role != RSV_TEXTURE_EMISSION && role != RSV_TEXTURE_NORMAL;
    }
    return glossy;
}

bool rsv_any_glossy(const rsv_transport_scene *scene)
{
    uint32_t k = 0;
    while (k < scene->view->material_count && !may_be_glossy(scene, k))
        k++;
    return k < scene->view->material_count;
}

// ---- maps ---------------------------------------------------------------------------------------

static bool same_transform(const rsv_texture_ref *a, const rsv_texture_ref *b)
{
    bool same = true;
    for (int k = 0; k < 6; k++)
        same = same && a->transform[k / 3][k % 3] == b->transform[k / 3][k % 3];
    return same;
}

/// Whether the texels of two maps lie in the same places.
static bool are_alike(
    const rsv_scene_view *scene, const rsv_texture_ref *a, const rsv_texture_ref *b)
{
    const rsv_texture *of_a = &scene->texture[a->texture], *of_b = &scene->texture[b->texture];
    return a->uv_set == b->uv_set && same_transform(a, b) &&
           of_a->level_count == of_b->level_count && of_a->wrap_u == of_b->wrap_u &&
           of_a->wrap_v == of_b->wrap_v && of_a->channel_count == of_b->channel_count &&
           of_a->level[0].width == of_b->level[0].width &&
           of_a->level[0].height == of_b->level[0].height;
}

static void set_maps(const rsv_scene_view *scene, const rsv_material *m, rsv_glossy_material *to)
{
    for (size_t k = 0; k < m->texture_count; k++) {
        int map = map_of_role(m->textures[k].role);
        if (map >= RSV_GLOSSY_MAPS) continue;
        if (map == RSV_GLOSSY_COLOR &&
            (rsv_glossy_has(to, RSV_GLOSSY_COLOR) || !is_packed(scene, &m->textures[k])))
            to->odd_color = 1;
        to->map[map] = m->textures[k];
        to->maps |= 1u << map;
    }
    if (to->odd_color) to->maps &= ~(1u << RSV_GLOSSY_COLOR);
    if (!to->maps) return;
    const rsv_texture_ref *first = &to->map[__builtin_ctz(to->maps)];
    for (int k = 0; k < RSV_GLOSSY_MAPS; k++)
        if (rsv_glossy_has(to, (rsv_glossy_map)k))
            to->alike |= (uint32_t)are_alike(scene, first, &to->map[k]) << k;
}

// ---- the tables ---------------------------------------------------------------------------------

/// Of an entry of the tables.
static float cosine_of(int k)
{
    float x = (float)k / (RSV_TABLE_COS - 1);
    return x * x;
}

static void fill_row(const rsv_bsdf *b, int k, rsv_glossy_row row)
{
    float cos = cosine_of(k);
    rsv_rgb base = rgb_scale(rsv_bsdf_exit(b, cos), b->diffuse), lobe = rsv_glossy_albedo(b, cos);
    memcpy(row, &base, sizeof base);
    memcpy(row + 4, &lobe, sizeof lobe);
    row[3] = row[7] = 0;
}

/// The material of that roughness everywhere.
static rsv_bsdf bsdf_of_level(const rsv_bsdf *common, const rsv_material *m, int level, int count,
    float metallic, float reflectance)
{
    rsv_material own = *m;
    rsv_bsdf varied;
    if (count > 1) own.roughness = (float)level / (float)(count - 1);
    own.metallic = metallic;
    own.base_color = rgb_gray(reflectance);
    rsv_bsdf_vary_entry(common, &own, &varied);
    return varied;
}

/// The polynomial through the albedos of black, grey and white metal.
static void fill_metal_row(const rsv_bsdf metal[3], int k, rsv_glossy_metal_row row)
{
    float cos = cosine_of(k);
    rsv_rgb a = rsv_glossy_albedo(&metal[0], cos), b = rsv_glossy_albedo(&metal[1], cos),
            c = rsv_glossy_albedo(&metal[2], cos);
    rsv_rgb bent = rgb_scale(rgb_add(rgb_sub(a, rgb_scale(b, 2)), c), 2);
    rsv_rgb slope = rgb_sub(rgb_sub(c, a), bent);
    memset(row, 0, sizeof(rsv_glossy_metal_row));
    memcpy(row[0], &a, sizeof a);
    memcpy(row[1], &slope, sizeof slope);
    memcpy(row[2], &bent, sizeof bent);
}

/// Tables of a material that textures change: they stay what they are when lights change.
static void fill_levels(const rsv_bsdf *common, const rsv_material *m, int count,
    rsv_glossy_row *row, rsv_glossy_metal_row *metal)
{
    for (int level = 0; level < count; level++) {
        rsv_bsdf dielectric = bsdf_of_level(common, m, level, count, 0, 0), of_metal[3];
        for (int k = 0; k < 3; k++)
            of_metal[k] = bsdf_of_level(common, m, level, count, 1, 0.5f * (float)k);
        for (int k = 0; k < RSV_TABLE_COS; k++) {
            fill_row(&dielectric, k, row[level * RSV_TABLE_COS + k]);
            if (metal) fill_metal_row(of_metal, k, metal[level * RSV_TABLE_COS + k]);
        }
    }
}

// ---- all materials ------------------------------------------------------------------------------

/// Constants, and the table of a material without variation.
static void fill_material(const rsv_transport_scene *scene, uint32_t material, rsv_glossy_row *row,
    rsv_glossy_material *to)
{
    const rsv_bsdf *b = &scene->bsdf[material];
    const rsv_material *m = &scene->view->material[material];
    bool textured = scene->view->material_varies[material] != 0;
    rsv_rgb color = textured ? m->base_color : b->base_color;
    rsv_rgb emission = b->emissive ? b->emission : rgb_gray(0);
    if (rsv_glossy_has(to, RSV_GLOSSY_EMISSION)) emission = m->emission;
    memcpy(to->base_color, &color, sizeof color);
    memcpy(to->emission, &emission, sizeof emission);
    to->metallic = to->metal ? m->metallic : 0;
    to->roughness = m->roughness;
    to->coat_alpha = b->clearcoat > 0 ? b->clearcoat_alpha : INFINITY;
    bool opaque = b->transmission == 0 && b->passed == 0;
    to->even = opaque && !b->layered && (to->metal || b->metallic == 0);
    to->bare = b->diffuse == 0;
    for (int k = 0; k < RSV_TABLE_COS && !rsv_glossy_is_general(to); k++)
        fill_row(b, k, row[k]);
}

/// Whether the surface is metallic in a way that the texture of a pixel decides.
static bool needs_metal(const rsv_material *m, const rsv_glossy_material *g)
{
    return m->metallic > 0 && (rsv_glossy_has(g, RSV_GLOSSY_COLOR) ||
                                  rsv_glossy_has(g, RSV_GLOSSY_METALLIC_ROUGHNESS));
}

/// Tables that plain materials need. @param metal number of those of metal, out @return number of all others
static size_t count_tables(const rsv_glossy_materials *g, size_t *metal)
{
    size_t count = 0;
    *metal = 0;
    for (uint32_t k = 0; k < g->scene->view->material_count; k++) {
        const rsv_glossy_material *m = &g->material[k];
        if (!m->plain) continue;
        count += (size_t)m->level_count;
        if (needs_metal(&g->scene->view->material[k], m)) *metal += (size_t)m->level_count;
    }
    return count;
}

static void hand_out_tables(rsv_glossy_materials *g)
{
    rsv_glossy_row *row = g->row;
    rsv_glossy_metal_row *metal = g->metal;
    for (uint32_t k = 0; k < g->scene->view->material_count; k++) {
        rsv_glossy_material *to = &g->material[k];
        const rsv_material *m = &g->scene->view->material[k];
        size_t size = (size_t)to->level_count * RSV_TABLE_COS;
        if (!to->plain) continue;
        rsv_glossy_metal_row *own = needs_metal(m, to) ? metal : NULL;
        to->row = row;
        to->metal = (const rsv_glossy_metal_row *)own;
        if (rsv_glossy_is_general(to)) fill_levels(&g->scene->bsdf[k], m, to->level_count, row, own);
        row += size;
        if (own) metal += size;
    }
}

rsv_status rsv_glossy_materials_create(rsv_context *context, const rsv_transport_scene *scene,
    const uint8_t *translucent, rsv_glossy_materials *g)
{
    size_t count = scene->view->material_count, metal;
    *g = (rsv_glossy_materials){ .context = context, .scene = scene };
    g->material = rsv_alloc(context, count, sizeof *g->material);
    if (!g->material) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < count; k++) {
        rsv_glossy_material *m = &g->material[k];
        m->plain = is_plain(scene, k) && !(translucent && translucent[k]);
        if (m->plain) set_maps(scene->view, &scene->view->material[k], m);
        bool rough = rsv_glossy_has(m, RSV_GLOSSY_METALLIC_ROUGHNESS);
        m->level_count = rough ? RSV_GLOSSY_LEVELS : 1;
    }
    size_t tables = count_tables(g, &metal);
    g->row = rsv_alloc(context, tables * RSV_TABLE_COS, sizeof *g->row);
    g->metal = rsv_alloc(context, metal * RSV_TABLE_COS, sizeof *g->metal);
    if ((tables > 0 && !g->row) || (metal > 0 && !g->metal)) return RSV_ERROR_MEMORY;
    hand_out_tables(g);
    rsv_glossy_materials_refresh(g);
    return RSV_OK;
}

void rsv_glossy_materials_destroy(rsv_glossy_materials *g)
{
    if (!g->context) return;
    rsv_free(g->context, g->material);
    rsv_free(g->context, g->row);
    rsv_free(g->context, g->metal);
    *g = (rsv_glossy_materials){ 0 };
}

void rsv_glossy_materials_refresh(rsv_glossy_materials *g)
{
    rsv_glossy_row *row = g->row;
    for (uint32_t k = 0; k < g->scene->view->material_count; k++) {
        rsv_glossy_material *m = &g->material[k];
        if (!m->plain) continue;
        fill_material(g->scene, k, row, m);
        row += (size_t)m->level_count * RSV_TABLE_COS;
    }
}
