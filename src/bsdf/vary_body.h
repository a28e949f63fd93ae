/// A material at one point (rsv_bsdf_vary).
#ifndef RSV_VARY_BODY_H
#define RSV_VARY_BODY_H

#include "balance.h"

RSV_INLINE rsv_rgb rsv_scaled_tint(rsv_rgb color, float scale)
{
    return rgb(f_min(color.r * scale, 1), f_min(color.g * scale, 1), f_min(color.b * scale, 1));
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

RSV_INLINE bool rsv_same_layers(const rsv_bsdf *a, const rsv_bsdf *b)
{
    rsv_layer_values of_a = rsv_bsdf_layer_values(a), of_b = rsv_bsdf_layer_values(b);
    bool same = true;
    RSV_ROLLED
    for (int k = 0; k < RSV_LAYER_VALUES; k++)
        same = same && of_a.value[k] == of_b.value[k];
    return same;
}

/// Whether all that `entry_scale` and `balance` follow from is the same: most textures vary no more than the base color.
RSV_INLINE bool rsv_same_interface(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->coated == b->coated && a->layered == b->layered && a->alpha == b->alpha &&
           a->metallic == b->metallic && a->transmission == b->transmission &&
           rsv_same_layers(a, b) && rsv_rgb_equal(a->specular_tint, b->specular_tint);
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
RSV_INLINE bool rsv_bsdf_vary_unbalanced(const rsv_bsdf *bsdf, const rsv_material *m, rsv_bsdf *to)
{
    rsv_bsdf varied = *bsdf;
    varied.base_color = m->base_color;
    varied.passed_color = m->diffuse_transmission_color;
    varied.emission = m->emission;
    varied.emissive = !rgb_is_black(m->emission);
    varied.specular_tint = rsv_scaled_tint(m->specular_color, m->specular);
    varied.metallic = m->metallic;
    varied.transmission = m->transmission;
    float under = (1 - m->metallic) * (1 - m->transmission);
    varied.passed = bsdf->solid ? 0 : under * m->diffuse_transmission;
    varied.diffuse = under - varied.passed;
    varied.alpha = rsv_microsurface_width(m->roughness);
    rsv_bsdf_set_layers(&varied, m);
    bool coat = varied.ior > 1 && !rgb_is_black(varied.specular_tint);
    varied.coated = coat || varied.layered;
    bool bends = coat || (m->transmission > 0 && !varied.straight);
    if (!bends && m->metallic == 0) varied.alpha = 0;
    varied.alpha_place = rsv_table_alpha(varied.alpha);
    varied.lambert = varied.diffuse == 1 && !varied.coated && !varied.solid;
    varied.rough = varied.alpha > 0 || varied.passed > 0 || rsv_bsdf_has_rough_layers(&varied);
    bool anew = rgb_is_black(bsdf->entry_scale) || !rsv_same_interface(&varied, bsdf);
    if (anew) varied.entry_scale = rsv_bsdf_entry_scale(&varied);
    *to = varied;
    return anew;
}

RSV_SHARED rsv_bsdf rsv_bsdf_vary(const rsv_bsdf *bsdf, const rsv_material *m)
{
    rsv_bsdf varied;
    if (bsdf->unlit) {
        varied = *bsdf;
        varied.emission = m->base_color;
    } else if (rsv_bsdf_vary_unbalanced(bsdf, m, &varied)) {
        rsv_bsdf_balance_layers(&varied);
    }
    return varied;
}

RSV_SHARED rsv_bsdf rsv_bsdf_vary_entry(const rsv_bsdf *bsdf, const rsv_material *m)
{
    rsv_bsdf varied = *bsdf;
    if (!bsdf->unlit) rsv_bsdf_vary_unbalanced(bsdf, m, &varied);
    return varied;
}

#endif
