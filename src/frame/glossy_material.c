#include "glossy_material.h"

#include "../core/core.h"
#include "../scene/material_at.h"

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

// ---- the table ----------------------------------------------------------------------------------

/// Whether textures change nothing but the base color, and with it nothing but the diffuse lobe.
static bool has_plain_textures(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_material *m = &scene->view->material[material];
    uint8_t varies = scene->view->material_varies[material];
    if (varies & (RSV_VARIES_BY_COLOR | RSV_VARIES_BY_OPACITY)) return false;
    for (size_t k = 0; k < m->texture_count; k++) {
        bool cover = m->textures[k].role == RSV_TEXTURE_OPACITY && m->alpha_cutoff > 0;
        if (m->textures[k].role != RSV_TEXTURE_BASE_COLOR && !cover) return false;
    }
    return !varies || m->metallic == 0;
}

static bool is_plain(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_bsdf *b = &scene->bsdf[material];
    const rsv_material *m = &scene->view->material[material];
    bool covers = m->alpha_cutoff > 0 || b->opacity >= 1;
    bool one_lobe = !b->layered && b->transmission == 0 && b->passed == 0 && b->alpha > 0;
    if (b->unlit || b->solid || rsv_hides_emission(b)) return false;
    return one_lobe && covers && has_plain_textures(scene, material);
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

static void fill_row(const rsv_bsdf *b, int k, rsv_glossy_row row)
{
    float x = (float)k / (RSV_TABLE_COS - 1), cos = x * x;
    rsv_rgb base = rgb_scale(rsv_bsdf_exit(b, cos), b->diffuse), lobe = rsv_glossy_albedo(b, cos);
    memcpy(row, &base, sizeof base);
    memcpy(row + 4, &lobe, sizeof lobe);
    row[3] = row[7] = 0;
}

static void fill_material(
    const rsv_transport_scene *scene, uint32_t material, rsv_glossy_material *to)
{
    const rsv_bsdf *b = &scene->bsdf[material];
    const rsv_material *m = &scene->view->material[material];
    bool textured = scene->view->material_varies[material] != 0;
    rsv_rgb color = textured ? m->base_color : b->base_color;
    rsv_rgb emission = b->emissive ? b->emission : rgb_gray(0);
    memcpy(to->base_color, &color, sizeof color);
    memcpy(to->emission, &emission, sizeof emission);
    to->alpha = b->alpha;
    to->even = b->metallic == 0 && m->roughness >= RSV_GLOSSY_EVEN_ROUGHNESS;
    to->bare = b->diffuse == 0;
    to->texture_count = 0;
    for (size_t k = 0; k < m->texture_count; k++)
        to->texture_count += m->textures[k].role == RSV_TEXTURE_BASE_COLOR;
    for (int k = 0; k < RSV_TABLE_COS; k++)
        fill_row(b, k, to->row[k]);
}

rsv_status rsv_glossy_materials_create(rsv_context *context, const rsv_transport_scene *scene,
    const uint8_t *translucent, rsv_glossy_materials *g)
{
    size_t count = scene->view->material_count;
    *g = (rsv_glossy_materials){ .context = context, .scene = scene };
    g->material = rsv_alloc(context, count, sizeof *g->material);
    if (!g->material) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < count; k++)
        g->material[k].plain = is_plain(scene, k) && !(translucent && translucent[k]);
    rsv_glossy_materials_refresh(g);
    return RSV_OK;
}

void rsv_glossy_materials_destroy(rsv_glossy_materials *g)
{
    if (g->context) rsv_free(g->context, g->material);
    *g = (rsv_glossy_materials){ 0 };
}

void rsv_glossy_materials_refresh(rsv_glossy_materials *g)
{
    for (uint32_t k = 0; k < g->scene->view->material_count; k++)
        if (g->material[k].plain) fill_material(g->scene, k, &g->material[k]);
}
