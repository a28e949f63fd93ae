#include "bsdf.h"

/// 1/m of a colour channel that nothing passes.
#define OPAQUE_ABSORPTION 1e9f

static rsv_rgb scaled_tint(rsv_rgb color, float scale)
{
    return rgb(f_min(color.r * scale, 1), f_min(color.g * scale, 1), f_min(color.b * scale, 1));
}

static float absorption(float color, float distance)
{
    if (!(distance < INFINITY) || color >= 1) return 0;
    if (color <= 0 || distance <= 0) return OPAQUE_ABSORPTION;
    return f_min(-logf(color) / distance, OPAQUE_ABSORPTION);
}

static rsv_bsdf unlit_bsdf(const rsv_material *material)
{
    return (rsv_bsdf){ .emission = material->base_color,
        .ior = 1,
        .diffuse = 1,
        .opacity = material->opacity,
        .double_sided = material->double_sided,
        .lambert = true,
        .unlit = true };
}

rsv_bsdf_variation rsv_bsdf_variation_of(const rsv_material *material)
{
    return (rsv_bsdf_variation){ .base_color = material->base_color,
        .emission = material->emission,
        .specular_tint = scaled_tint(material->specular_color, material->specular),
        .metallic = material->metallic,
        .roughness = material->roughness,
        .transmission = material->transmission,
        .sheen_color = material->sheen_color,
        .diffuse_transmission_color = material->diffuse_transmission_color,
        .clearcoat = material->clearcoat,
        .clearcoat_roughness = material->clearcoat_roughness,
        .sheen_roughness = material->sheen_roughness,
        .diffuse_transmission = material->diffuse_transmission };
}

static float width_of(float roughness)
{
    float alpha = roughness * roughness;
    return alpha < RSV_SMOOTH_ALPHA ? 0 : alpha;
}

typedef rsv_rgb (*cosine_function)(const rsv_bsdf *bsdf, float cos);

/// 2 int f cos dcos, by Gauss's rule of eight points in x = sqrt(cos), 4 int f x^3 dx.
static rsv_rgb hemispherical_mean(const rsv_bsdf *bsdf, cosine_function f)
{
    static const float place[4] = { 0.1834346424956498f, 0.5255324099163290f, 0.7966664774136267f,
        0.9602898564975363f };
    static const float weight[4] = { 0.3626837833783620f, 0.3137066458778873f, 0.2223810344533745f,
        0.1012285362903763f };
    rsv_rgb sum = rgb_gray(0);
    for (int k = 0; k < 8; k++) {
        float x = 0.5f + (k & 1 ? 0.5f : -0.5f) * place[k / 2];
        sum = rgb_mad(sum, 2 * weight[k / 2] * x * x * x, f(bsdf, x * x));
    }
    return sum;
}

static rsv_rgb coated_sheen(const rsv_bsdf *bsdf, float cos)
{
    return rgb_gray(rsv_bsdf_coated_sheen(bsdf, cos));
}

static float sheen_mean(const rsv_bsdf *bsdf)
{
    float k = bsdf->sheen_power;
    if (bsdf->clearcoat == 0) return 2 / ((k + 1) * (k + 2));
    return hemispherical_mean(bsdf, coated_sheen).r;
}

static void set_layers(rsv_bsdf *bsdf, const rsv_bsdf_variation *v)
{
    bsdf->clearcoat = v->clearcoat;
    bsdf->clearcoat_alpha = width_of(v->clearcoat_roughness);
    bsdf->clearcoat_place = rsv_table_alpha(bsdf->clearcoat_alpha);
    bsdf->sheen = v->sheen_color;
    bsdf->sheen_power = 2 / f_max(v->sheen_roughness, 0.1f);
    bsdf->layered = v->clearcoat > 0 || !rgb_is_black(v->sheen_color);
    if (!rgb_is_black(v->sheen_color)) bsdf->sheen_mean = sheen_mean(bsdf);
}

static rsv_rgb entry_mean(const rsv_bsdf *bsdf)
{
    if (!bsdf->coated) return rgb_gray(1);
    if (bsdf->layered) return hemispherical_mean(bsdf, rsv_bsdf_entry);
    float reflected = bsdf->alpha == 0 ? bsdf->smooth_mean
                                       : rsv_table_mean(bsdf->tables->reflected_mean,
                                             bsdf->eta_place, bsdf->alpha_place);
    return rsv_one_minus(rgb_scale(bsdf->specular_tint, reflected));
}

static bool equal(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// Whether all that `entry_mean` and `balance` follow from is the same: most textures vary no more than the base color.
static bool same_interface(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->coated == b->coated && a->layered == b->layered && a->alpha == b->alpha &&
           a->metallic == b->metallic && a->transmission == b->transmission &&
           a->clearcoat == b->clearcoat && a->clearcoat_alpha == b->clearcoat_alpha &&
           a->sheen_power == b->sheen_power && equal(a->sheen, b->sheen) &&
           equal(a->specular_tint, b->specular_tint);
}

static rsv_rgb divided(rsv_rgb a, rsv_rgb b) { return rgb(a.r / b.r, a.g / b.g, a.b / b.b); }

rsv_bsdf rsv_bsdf_vary(const rsv_bsdf *bsdf, const rsv_bsdf_variation *v)
{
    rsv_bsdf varied = *bsdf;
    if (bsdf->unlit) {
        varied.emission = v->base_color;
        return varied;
    }
    varied.base_color = v->base_color;
    varied.emission = v->emission;
    varied.emissive = !rgb_is_black(v->emission);
    varied.specular_tint = v->specular_tint;
    varied.metallic = v->metallic;
    varied.transmission = v->transmission;
    float under = (1 - v->metallic) * (1 - v->transmission);
    varied.passed = bsdf->solid ? 0 : under * v->diffuse_transmission;
    varied.diffuse = under - varied.passed;
    varied.alpha = width_of(v->roughness);
    set_layers(&varied, v);
    bool coat = varied.ior > 1 && !rgb_is_black(v->specular_tint);
    varied.coated = coat || varied.layered;
    if (!coat && v->metallic == 0 && v->transmission == 0) varied.alpha = 0;
    varied.alpha_place = rsv_table_alpha(varied.alpha);
    varied.lambert = varied.diffuse == 1 && !varied.coated && !varied.solid;
    varied.rough = varied.alpha > 0 || varied.passed > 0 || !rgb_is_black(varied.sheen) ||
                   (v->clearcoat > 0 && varied.clearcoat_alpha > 0);
    if (rgb_is_black(bsdf->entry_mean) || !same_interface(&varied, bsdf)) {
        varied.entry_mean = entry_mean(&varied);
        rsv_bsdf_balance_layers(&varied);
    }
    varied.exitance_albedo = divided(v->base_color, varied.entry_mean);
    varied.passed_albedo = divided(v->diffuse_transmission_color, varied.entry_mean);
    return varied;
}

rsv_bsdf rsv_bsdf_from_material(const rsv_material *material)
{
    if (material->unlit) return unlit_bsdf(material);
    rsv_bsdf bsdf = { .ior = f_max(material->ior, 1),
        .opacity = material->opacity,
        .tables = &rsv_bsdf_tables_data };
    bsdf.smooth_mean = (float)rsv_fresnel_dielectric_mean(bsdf.ior);
    bsdf.eta_place = rsv_table_eta(bsdf.ior);
    bsdf.clearcoat_eta_place = rsv_table_eta(RSV_CLEARCOAT_IOR);
    bsdf.solid = material->thickness > 0 && material->transmission > 0 && material->metallic < 1;
    bsdf.double_sided = material->double_sided || bsdf.solid;
    if (bsdf.solid) bsdf.opacity = 1; // a body has no holes
    if (bsdf.solid) {
        float distance = material->attenuation_distance;
        bsdf.absorption = rgb(absorption(material->attenuation_color.r, distance),
            absorption(material->attenuation_color.g, distance),
            absorption(material->attenuation_color.b, distance));
    }
    rsv_bsdf_variation variation = rsv_bsdf_variation_of(material);
    return rsv_bsdf_vary(&bsdf, &variation);
}
