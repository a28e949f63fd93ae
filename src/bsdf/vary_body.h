/// A material at one point (rsv_bsdf_vary).
#ifndef RSV_VARY_BODY_H
#define RSV_VARY_BODY_H

#include "balance.h"

RSV_INLINE rsv_rgb rsv_scaled_tint(rsv_rgb color, float scale)
{
    return rgb(f_min(color.r * scale, 1), f_min(color.g * scale, 1), f_min(color.b * scale, 1));
}

RSV_SHARED rsv_bsdf_variation rsv_bsdf_variation_of(const rsv_material *material)
{
    rsv_bsdf_variation v;
    v.base_color = material->base_color;
    v.emission = material->emission;
    v.specular_tint = rsv_scaled_tint(material->specular_color, material->specular);
    v.metallic = material->metallic;
    v.roughness = material->roughness;
    v.transmission = material->transmission;
    v.sheen_color = material->sheen_color;
    v.diffuse_transmission_color = material->diffuse_transmission_color;
    v.clearcoat = material->clearcoat;
    v.clearcoat_roughness = material->clearcoat_roughness;
    v.sheen_roughness = material->sheen_roughness;
    v.diffuse_transmission = material->diffuse_transmission;
    return v;
}

RSV_INLINE float rsv_microsurface_width(float roughness)
{
    float alpha = roughness * roughness;
    return alpha < RSV_SMOOTH_ALPHA ? 0 : alpha;
}

/// Means over the hemisphere, 2 int f cos dcos, are sums of so many values of f.
#define RSV_MEAN_NODES 8

/// Gauss's rule in x = sqrt(cos), 4 int f x^3 dx. @return the weight of node k
RSV_INLINE float rsv_mean_node(int k, float *cos)
{
    const float place[4] = { 0.1834346424956498f, 0.5255324099163290f, 0.7966664774136267f,
        0.9602898564975363f };
    const float weight[4] = { 0.3626837833783620f, 0.3137066458778873f, 0.2223810344533745f,
        0.1012285362903763f };
    float x = 0.5f + (k & 1 ? 0.5f : -0.5f) * place[k / 2];
    *cos = x * x;
    return 2 * weight[k / 2] * x * x * x;
}

RSV_INLINE float rsv_bsdf_sheen_mean(const rsv_bsdf *bsdf)
{
    float k = bsdf->sheen_power;
    if (bsdf->clearcoat == 0) return 2 / ((k + 1) * (k + 2));
    float sum = 0;
    RSV_ROLLED
    for (int n = 0; n < RSV_MEAN_NODES; n++) {
        float cos, weight = rsv_mean_node(n, &cos);
        sum += weight * rsv_bsdf_coated_sheen(bsdf, cos);
    }
    return sum;
}

RSV_INLINE void rsv_bsdf_set_layers(rsv_bsdf *bsdf, const rsv_bsdf_variation *v)
{
    bsdf->clearcoat = v->clearcoat;
    bsdf->clearcoat_alpha = rsv_microsurface_width(v->clearcoat_roughness);
    bsdf->clearcoat_place = rsv_table_alpha(bsdf->clearcoat_alpha);
    bsdf->sheen = v->sheen_color;
    bsdf->sheen_power = 2 / f_max(v->sheen_roughness, 0.1f);
    bsdf->layered = v->clearcoat > 0 || !rgb_is_black(v->sheen_color);
    if (!rgb_is_black(v->sheen_color)) bsdf->sheen_mean = rsv_bsdf_sheen_mean(bsdf);
}

RSV_INLINE rsv_rgb rsv_bsdf_layered_exit_mean(const rsv_bsdf *bsdf)
{
    rsv_rgb sum = rgb_gray(0);
    RSV_ROLLED
    for (int n = 0; n < RSV_MEAN_NODES; n++) {
        float cos, weight = rsv_mean_node(n, &cos);
        sum = rgb_mad(sum, weight, rsv_bsdf_exit(bsdf, cos));
    }
    return sum;
}

/// T_mean
RSV_INLINE rsv_rgb rsv_bsdf_exit_mean(const rsv_bsdf *bsdf)
{
    if (!bsdf->coated) return rgb_gray(1);
    if (bsdf->layered) return rsv_bsdf_layered_exit_mean(bsdf);
    float reflected = bsdf->alpha == 0 ? bsdf->smooth_mean
                                       : rsv_table_mean(bsdf->tables->reflected_mean,
                                             bsdf->eta_place, bsdf->alpha_place);
    return rsv_one_minus(rgb_scale(bsdf->specular_tint, reflected));
}

RSV_INLINE bool rsv_rgb_equal(rsv_rgb a, rsv_rgb b)
{
    return a.r == b.r && a.g == b.g && a.b == b.b;
}

/// Whether all that `entry_scale` and `balance` follow from is the same: most textures vary no more than the base color.
RSV_INLINE bool rsv_same_interface(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->coated == b->coated && a->layered == b->layered && a->alpha == b->alpha &&
           a->metallic == b->metallic && a->transmission == b->transmission &&
           a->clearcoat == b->clearcoat && a->clearcoat_alpha == b->clearcoat_alpha &&
           a->sheen_power == b->sheen_power && rsv_rgb_equal(a->sheen, b->sheen) &&
           rsv_rgb_equal(a->specular_tint, b->specular_tint);
}

/// Below this nothing gets in or out.
#define RSV_LEAST_EXIT 1e-6f

RSV_INLINE rsv_rgb rsv_bsdf_entry_scale(const rsv_bsdf *bsdf)
{
    rsv_rgb mean = rsv_bsdf_exit_mean(bsdf);
    return rgb(1 / f_max(mean.r, RSV_LEAST_EXIT), 1 / f_max(mean.g, RSV_LEAST_EXIT),
        1 / f_max(mean.b, RSV_LEAST_EXIT));
}

/// All but what rough lobes under layers need. @return whether they do
RSV_INLINE bool rsv_bsdf_vary_unbalanced(
    const rsv_bsdf *bsdf, const rsv_bsdf_variation *v, rsv_bsdf *to)
{
    rsv_bsdf varied = *bsdf;
    varied.base_color = v->base_color;
    varied.passed_color = v->diffuse_transmission_color;
    varied.emission = v->emission;
    varied.emissive = !rgb_is_black(v->emission);
    varied.specular_tint = v->specular_tint;
    varied.metallic = v->metallic;
    varied.transmission = v->transmission;
    float under = (1 - v->metallic) * (1 - v->transmission);
    varied.passed = bsdf->solid ? 0 : under * v->diffuse_transmission;
    varied.diffuse = under - varied.passed;
    varied.alpha = rsv_microsurface_width(v->roughness);
    rsv_bsdf_set_layers(&varied, v);
    bool coat = varied.ior > 1 && !rgb_is_black(v->specular_tint);
    varied.coated = coat || varied.layered;
    bool bends = coat || (v->transmission > 0 && !varied.straight);
    if (!bends && v->metallic == 0) varied.alpha = 0;
    varied.alpha_place = rsv_table_alpha(varied.alpha);
    varied.lambert = varied.diffuse == 1 && !varied.coated && !varied.solid;
    varied.rough = varied.alpha > 0 || varied.passed > 0 || !rgb_is_black(varied.sheen) ||
                   (v->clearcoat > 0 && varied.clearcoat_alpha > 0);
    bool anew = rgb_is_black(bsdf->entry_scale) || !rsv_same_interface(&varied, bsdf);
    if (anew) varied.entry_scale = rsv_bsdf_entry_scale(&varied);
    *to = varied;
    return anew;
}

RSV_SHARED rsv_bsdf rsv_bsdf_vary(const rsv_bsdf *bsdf, const rsv_bsdf_variation *v)
{
    rsv_bsdf varied;
    if (bsdf->unlit) {
        varied = *bsdf;
        varied.emission = v->base_color;
    } else if (rsv_bsdf_vary_unbalanced(bsdf, v, &varied)) {
        rsv_bsdf_balance_layers(&varied);
    }
    return varied;
}

RSV_SHARED rsv_bsdf rsv_bsdf_vary_entry(const rsv_bsdf *bsdf, const rsv_bsdf_variation *v)
{
    rsv_bsdf varied = *bsdf;
    if (!bsdf->unlit) rsv_bsdf_vary_unbalanced(bsdf, v, &varied);
    return varied;
}

#endif
