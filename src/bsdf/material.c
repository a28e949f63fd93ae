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
        .transmission = material->transmission };
}

static bool has_interface(const rsv_bsdf *bsdf)
{
    return bsdf->coated || bsdf->metallic > 0 || bsdf->transmission > 0;
}

static void set_exitance(rsv_bsdf *bsdf)
{
    float reflected = !bsdf->coated      ? 0
                      : bsdf->alpha == 0 ? bsdf->smooth_mean
                                         : rsv_table_mean(bsdf->tables->reflected_mean,
                                               bsdf->eta_place, bsdf->alpha_place);
    rsv_rgb a = bsdf->base_color, s = bsdf->specular_tint;
    bsdf->exitance_albedo =
        rgb(a.r / (1 - s.r * reflected), a.g / (1 - s.g * reflected), a.b / (1 - s.b * reflected));
}

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
    varied.diffuse = (1 - v->metallic) * (1 - v->transmission);
    varied.coated = varied.ior > 1 && !rgb_is_black(v->specular_tint);
    varied.alpha = v->roughness * v->roughness;
    if (varied.alpha < RSV_SMOOTH_ALPHA || !has_interface(&varied)) varied.alpha = 0;
    varied.alpha_place = rsv_table_alpha(varied.alpha);
    varied.lambert = varied.diffuse == 1 && !varied.coated && !varied.solid;
    set_exitance(&varied);
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
