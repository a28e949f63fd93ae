/// The lobes of a point: their shapes and albedos.
#include "lobe_polygon.h"

/// Where wide lobes send less than this share of the base's light, the base takes it on.
#define NEGLIGIBLE 0.003f

static void set_frame(rsv_highlight_lobes *l)
{
    const rsv_highlight_point *p = &l->point;
    rsv_vec3 away = v3_sub(v3_scale(p->normal, l->cos_o), p->wo);
    float length = v3_length(away);
    if (length > 1e-4f) {
        l->tangent = v3_scale(away, 1 / length);
        l->bitangent = v3_cross(p->normal, l->tangent);
    } else {
        v3_frame(p->normal, &l->tangent, &l->bitangent);
    }
}

static rsv_highlight_lobe *add_lobe(
    rsv_highlight_lobes *l, uint32_t kind, rsv_lobe_shape shape, rsv_rgb albedo)
{
    rsv_highlight_lobe *lobe = &l->lobe[l->count++];
    *lobe = (rsv_highlight_lobe){ shape, albedo, kind, 0 };
    return lobe;
}

/// Where the shape fits badly, and where the Fresnel reflectance of dielectrics varies over wide lobes, polygons are cut.
#define WELL_FITTED 0.002f
#define FITTED 0.012f
#define WIDE_ALPHA 0.2f

static uint32_t cuts_of(const rsv_lobe_fit *fit, float alpha, float metallic)
{
    if (fit->misfit > FITTED) return RSV_MOST_CUTS;
    bool varies = alpha > WIDE_ALPHA && metallic < 0.5f;
    return fit->misfit > WELL_FITTED || varies ? 2 : 0;
}

static rsv_lobe_shape ggx_shape(const rsv_highlight_lobes *l, const rsv_lobe_fit *fit, float alpha)
{
    float sin_o = sqrtf(f_max(1 - l->cos_o * l->cos_o, 0));
    return rsv_lobe_shape_of(fit, alpha, l->cos_o, sin_o);
}

/// Where the albedo is not tabulated, that of the facets on the axis stands for it.
static rsv_rgb color_on_axis(const rsv_highlight_lobes *l, const rsv_lobe_shape *shape)
{
    rsv_vec3 axis = v3_normalize(v3_mad(l->point.normal, shape->lean, l->tangent));
    rsv_vec3 h = v3_normalize(v3_add(axis, l->point.wo));
    return rsv_facet_color(l, v3_dot(l->point.wo, h), v3_dot(l->point.normal, axis));
}

/// Metal and interface, reflected once. @param white albedo of white metal
static rsv_rgb base_albedo(
    const rsv_highlight_lobes *l, const rsv_lobe_fit *fit, float white, rsv_rgb left)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_rgb f0 = bsdf->base_color;
    rsv_rgb metal = rgb_scale(rgb_mad(f0, fit->grazing, rsv_one_minus(f0)), white * bsdf->metallic);
    rsv_rgb interface = rgb_scale(
        bsdf->specular_tint, (1 - bsdf->metallic) * rsv_bsdf_interface_albedo(bsdf, l->cos_o));
    return rgb_mul(rgb_add(metal, interface), left);
}

/// Sets what the wide lobes have of wo; their albedo follows.
static rsv_rgb set_wide(rsv_highlight_lobes *l, rsv_rgb left, rsv_rgb *through)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    l->metal_again = l->glass_again = l->glass_through = *through = rgb_gray(0);
    if (bsdf->alpha > 0 && bsdf->metallic > 0)
        l->metal_again = rgb_scale(rsv_bsdf_metal_again(bsdf),
            bsdf->metallic * rsv_bsdf_missing(bsdf, false, 0, l->cos_o));
    float glass = (1 - bsdf->metallic) * bsdf->transmission;
    if (bsdf->alpha > 0 && glass > 0 && !bsdf->straight) {
        int here = bsdf->solid && !l->point.front;
        float transmitted = rsv_bsdf_missing_transmitted(bsdf, here);
        float missing = glass * rsv_bsdf_missing(bsdf, bsdf->solid, here, l->cos_o);
        l->glass_again = rgb_gray(missing * (1 - transmitted));
        if (!bsdf->solid) l->glass_through = rgb_scale(bsdf->base_color, missing * transmitted);
        *through = rgb_mul(l->glass_through, left);
    }
    rsv_rgb albedo = rgb_mul(rgb_add(l->metal_again, l->glass_again), left);
    if (!l->layered) return albedo;
    l->wide = rsv_bsdf_wide_layers(bsdf, l->cos_o);
    return rgb_add(albedo, rsv_wide_layers_albedo(&l->wide));
}

static const rsv_lobe_shape cosine = { 0, 1, 1 };

/// @return albedo of the base
static rsv_rgb add_base(rsv_highlight_lobes *l, rsv_table_place cos, rsv_rgb left)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_lobe_fit fit = rsv_lobe_fit_at(bsdf->alpha_place, cos);
    float white = 1 - rsv_bsdf_missing(bsdf, false, 0, l->cos_o);
    rsv_lobe_shape shape = ggx_shape(l, &fit, bsdf->alpha);
    bool inside = bsdf->solid && !l->point.front && bsdf->metallic < 1;
    rsv_rgb albedo =
        inside ? rgb_scale(color_on_axis(l, &shape), white) : base_albedo(l, &fit, white, left);
    uint32_t cuts = cuts_of(&fit, bsdf->alpha, bsdf->metallic);
    add_lobe(l, RSV_HIGHLIGHT_BASE, shape, albedo)->cuts = cuts;
    float sheet = bsdf->solid || bsdf->straight ? 0 : (1 - bsdf->metallic) * bsdf->transmission;
    if (!(sheet > 0)) return albedo;
    rsv_rgb kept = rgb_scale(bsdf->specular_tint, rsv_bsdf_interface_albedo(bsdf, l->cos_o));
    rsv_rgb passed = rgb_scale(rgb_positive(rgb_sub(rgb_gray(white), kept)), sheet);
    add_lobe(l, RSV_HIGHLIGHT_SHEET, shape, rgb_mul(rgb_mul(passed, bsdf->base_color), left))
        ->cuts = cuts;
    return albedo;
}

static void add_coat(rsv_highlight_lobes *l, rsv_table_place cos)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_lobe_fit fit = rsv_lobe_fit_at(bsdf->clearcoat_place, cos);
    add_lobe(l, RSV_HIGHLIGHT_COAT, ggx_shape(l, &fit, bsdf->clearcoat_alpha),
        rgb_gray(rsv_bsdf_clearcoat_albedo(bsdf, l->cos_o)))
        ->cuts = cuts_of(&fit, bsdf->clearcoat_alpha, 0);
}

bool rsv_highlight_prepare(const rsv_highlight_point *point, rsv_highlight_lobes *l)
{
    const rsv_bsdf *bsdf = point->bsdf;
    l->point = *point;
    l->count = 0;
    l->refracts = bsdf->solid && bsdf->alpha > 0 && !bsdf->straight && bsdf->transmission > 0;
    l->cos_o = f_min(v3_dot(point->normal, point->wo), 1);
    if (!bsdf->rough || rsv_bsdf_is_black_side(bsdf, point->front) || !(l->cos_o > 0)) return false;
    set_frame(l);
    l->layered = rsv_bsdf_meets_layers(bsdf, point->front);
    rsv_rgb left = rgb_gray(1), through, base = rgb_gray(0);
    if (l->layered) {
        left = rsv_bsdf_passage(bsdf, l->cos_o).light;
        for (int k = 0; k < RSV_SPREADS && bsdf->alpha > 0; k++)
            l->way[k] = rsv_bsdf_way(bsdf, k, l->cos_o);
    }
    rsv_table_place cos = rsv_table_cos(l->cos_o);
    if (bsdf->alpha > 0) base = add_base(l, cos, left);
    if (l->layered && bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0) add_coat(l, cos);
    rsv_rgb wide = set_wide(l, left, &through);
    if (rgb_max(wide) > NEGLIGIBLE * rgb_max(base))
        add_lobe(l, RSV_HIGHLIGHT_WIDE, cosine, wide);
    else if (bsdf->alpha > 0)
        l->lobe[0].albedo = rgb_add(base, wide);
    if (bsdf->passed > 0)
        through = rgb_mad(
            through, bsdf->passed, rgb_mul(rsv_bsdf_exit(bsdf, l->cos_o), bsdf->passed_color));
    if (!rgb_is_black(through)) add_lobe(l, RSV_HIGHLIGHT_PASSED, cosine, through);
    return l->count > 0;
}

rsv_rgb rsv_highlight_albedo(const rsv_highlight_lobes *l)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < l->count; k++)
        sum = rgb_add(sum, l->lobe[k].albedo);
    return sum;
}
