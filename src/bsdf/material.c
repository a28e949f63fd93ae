#include "bsdf.h"

#include <stdio.h>

/// Rougher metal reflects more like a Lambert surface than like a mirror.
#define ROUGHEST_MIRROR 0.5f
/// A rougher coat has no highlight worth the name.
#define ROUGHEST_COAT 0.25f
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

static float exitance_albedo(float base_color, float specular_tint, double fresnel_mean)
{
    return (float)(base_color / (1 - specular_tint * fresnel_mean));
}

/// Replaces rough lobes by the nearest ideal ones and names the most visible replacement.
static void idealise_lobes(rsv_bsdf *bsdf, float roughness, char *approximation)
{
    const char *phrase = NULL;
    bool reflective = bsdf->ior > 1 && !rgb_is_black(bsdf->specular_tint);
    if (bsdf->metallic < 1 && bsdf->transmission > 0) {
        phrase = "rough transmission (%.2f) shown as clear";
    } else if (bsdf->metallic < 1 && reflective) {
        phrase = "rough reflection (%.2f) shown as a smooth coat";
        if (roughness >= ROUGHEST_COAT) {
            phrase = "rough reflection (%.2f) left out";
            bsdf->specular_tint = rgb_gray(0);
        }
    }
    if (bsdf->metallic > 0) {
        phrase = "rough metal (%.2f) shown as an ideal mirror";
        if (roughness >= ROUGHEST_MIRROR) {
            phrase = "rough metal (%.2f) shown as diffuse";
            bsdf->metallic = 0;
            if (bsdf->transmission == 0) bsdf->specular_tint = rgb_gray(0);
        }
    }
    if (phrase && roughness > 0) snprintf(approximation, 80, phrase, (double)roughness);
}

static rsv_bsdf unlit_bsdf(const rsv_material *material)
{
    return (rsv_bsdf){ .emission = material->base_color,
        .ior = 1,
        .diffuse = 1,
        .double_sided = material->double_sided,
        .lambert = true,
        .unlit = true };
}

rsv_bsdf rsv_bsdf_from_material(const rsv_material *material, char *approximation)
{
    approximation[0] = 0;
    if (material->unlit) return unlit_bsdf(material);
    rsv_bsdf bsdf = { .base_color = material->base_color,
        .emission = material->emission,
        .specular_tint = scaled_tint(material->specular_color, material->specular),
        .ior = f_max(material->ior, 1),
        .metallic = material->metallic,
        .transmission = material->transmission,
        .emissive = !rgb_is_black(material->emission) };
    idealise_lobes(&bsdf, material->roughness, approximation);

    bsdf.diffuse = (1 - bsdf.metallic) * (1 - bsdf.transmission);
    bsdf.coated = bsdf.ior > 1 && !rgb_is_black(bsdf.specular_tint);
    bsdf.solid = material->thickness > 0 && bsdf.transmission > 0 && bsdf.metallic < 1;
    bsdf.double_sided = material->double_sided || bsdf.solid;
    bsdf.lambert = bsdf.diffuse == 1 && !bsdf.coated && !bsdf.solid;
    if (bsdf.solid) {
        float distance = material->attenuation_distance;
        bsdf.absorption = rgb(absorption(material->attenuation_color.r, distance),
            absorption(material->attenuation_color.g, distance),
            absorption(material->attenuation_color.b, distance));
    }
    double mean = bsdf.coated ? rsv_fresnel_dielectric_mean(bsdf.ior) : 0;
    bsdf.exitance_albedo = rgb(exitance_albedo(bsdf.base_color.r, bsdf.specular_tint.r, mean),
        exitance_albedo(bsdf.base_color.g, bsdf.specular_tint.g, mean),
        exitance_albedo(bsdf.base_color.b, bsdf.specular_tint.b, mean));
    return bsdf;
}
