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
    if (bsdf->film.share > 0)
        return rsv_one_minus(rsv_filmed_mean(bsdf, RSV_FILMED_COAT, bsdf->alpha_place));
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

RSV_INLINE bool rsv_same_brush(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->brushed == b->brushed && (!a->brushed || (a->brush_along == b->brush_along &&
                                                           a->brush_across == b->brush_across));
}

/// Whether all inputs of `entry_scale` and `balance` are equal: most textures vary only the base colour.
RSV_INLINE bool rsv_same_interface(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->coated == b->coated && a->layered == b->layered && a->alpha == b->alpha &&
           a->metallic == b->metallic && a->transmission == b->transmission &&
           rsv_same_brush(a, b) && rsv_same_layers(a, b) &&
           rsv_rgb_equal(a->specular_tint, b->specular_tint);
}

/// Sets the widths of facets. Only metal's are brushed: all others take the geometric mean.
RSV_INLINE void rsv_bsdf_set_brush(rsv_bsdf *bsdf, const rsv_material *m)
{
    bsdf->brushed = m->anisotropy > 0 && m->metallic > 0;
    if (!(m->anisotropy > 0)) return;
    bsdf->brush_across = f_max(m->roughness * m->roughness, RSV_SMOOTH_ALPHA);
    bsdf->brush_along = rsv_brushed_along(bsdf->brush_across, m->anisotropy);
    bsdf->brush_alpha = rsv_table_place_at(sqrtf(bsdf->brush_across), RSV_BRUSHED_ALPHA);
    bsdf->brush_strength = rsv_table_place_at(m->anisotropy, RSV_BRUSHED_STRENGTH);
    bsdf->alpha = sqrtf(bsdf->brush_across * bsdf->brush_along);
}

/// Whether facets under the film have the same reflectance.
RSV_INLINE bool rsv_same_film(const rsv_bsdf *a, const rsv_bsdf *b)
{
    return a->film.share == b->film.share && a->film.ior == b->film.ior &&
           a->film.thickness == b->film.thickness && a->metallic == b->metallic &&
           rsv_rgb_equal(a->specular_tint, b->specular_tint) &&
           (a->metallic == 0 || rsv_rgb_equal(a->base_color, b->base_color));
}

/// Fraction of the film on a body of that roughness. Multiple scattering is tabulated for bodies without a film, which
/// absorbs up to 1 %. Films therefore fade away with roughness, so that no light is gained.
RSV_INLINE float rsv_film_share(const rsv_bsdf *bsdf, float share)
{
    const float full = 0.05f, none = 0.25f;
    if (bsdf->straight) return 0;
    return bsdf->solid ? share * f_min(f_max((none - bsdf->alpha) / (none - full), 0), 1) : share;
}

/// Sets the film of a surface whose interface is known. @param like the bsdf that the surface was made from
RSV_INLINE void rsv_bsdf_set_film(rsv_bsdf *bsdf, const rsv_bsdf *like, const rsv_material *m)
{
    float micrometres = f_min(m->iridescence_thickness_max, 1e9f) / 1000;
    rsv_thin_film film = { rsv_film_share(bsdf, m->iridescence),
        f_min(m->iridescence_ior, RSV_MOST_IOR), micrometres };
    if (!(micrometres > 0)) film.share = 0;
    bsdf->film = film;
    if (film.share == 0 || rsv_same_film(bsdf, like)) return;
    RSV_ROLLED
    for (int k = 0; k < RSV_FACET_COS; k++) {
        float cos = (float)k / (RSV_FACET_COS - 1);
        if (bsdf->metallic > 0)
            bsdf->filmed[RSV_FILMED_METAL][k] = rsv_bsdf_filmed(bsdf, RSV_FILMED_METAL, cos);
        if (bsdf->metallic < 1)
            bsdf->filmed[RSV_FILMED_COAT][k] = rsv_bsdf_filmed(bsdf, RSV_FILMED_COAT, cos);
    }
}

/// Below this nothing gets in or out.
#define RSV_LEAST_EXIT 1e-6f

RSV_INLINE rsv_rgb rsv_bsdf_entry_scale(const rsv_bsdf *bsdf)
{
    rsv_rgb mean = rsv_bsdf_exit_mean(bsdf);
    return rgb(1 / f_max(mean.r, RSV_LEAST_EXIT), 1 / f_max(mean.g, RSV_LEAST_EXIT),
        1 / f_max(mean.b, RSV_LEAST_EXIT));
}

/// Everything except what rough lobes under layers need. @return whether they need it
RSV_INLINE bool rsv_bsdf_vary_unbalanced(const rsv_bsdf *bsdf, const rsv_material *m, rsv_bsdf *to)
{
    *to = *bsdf;
    to->base_color = m->base_color;
    to->passed_color = m->diffuse_transmission_color;
    to->emission = m->emission;
    to->emissive = !rgb_is_black(m->emission);
    to->specular_tint = rsv_scaled_tint(m->specular_color, m->specular);
    to->metallic = m->metallic;
    to->transmission = m->transmission;
    float under = (1 - m->metallic) * (1 - m->transmission);
    to->passed = bsdf->solid ? 0 : under * m->diffuse_transmission;
    to->diffuse = under - to->passed;
    to->alpha = rsv_microsurface_width(m->roughness);
    rsv_bsdf_set_brush(to, m);
    rsv_bsdf_set_layers(to, m);
    rsv_bsdf_set_film(to, bsdf, m);
    bool bends_at_coat = to->ior > 1 || to->film.share > 0;
    bool coat = bends_at_coat && !rgb_is_black(to->specular_tint);
    to->coated = coat || to->layered;
    bool bends = coat || (m->transmission > 0 && !to->straight);
    if (!bends && m->metallic == 0) to->alpha = 0;
    to->alpha_place = rsv_table_alpha(to->alpha);
    to->lambert = to->diffuse == 1 && !to->coated && !to->solid;
    to->rough = to->alpha > 0 || to->passed > 0 || rsv_bsdf_has_rough_layers(to);
    bool anew = rgb_is_black(bsdf->entry_scale) || !rsv_same_interface(to, bsdf);
    if (anew) to->entry_scale = rsv_bsdf_entry_scale(to);
    return anew;
}

RSV_SHARED void rsv_bsdf_vary(const rsv_bsdf *bsdf, const rsv_material *m, rsv_bsdf *varied)
{
    if (bsdf->unlit) {
        *varied = *bsdf;
        varied->emission = m->base_color;
    } else if (rsv_bsdf_vary_unbalanced(bsdf, m, varied)) {
        rsv_bsdf_balance_layers(varied);
    }
}

RSV_SHARED void rsv_bsdf_vary_entry(const rsv_bsdf *bsdf, const rsv_material *m, rsv_bsdf *varied)
{
    if (bsdf->unlit)
        *varied = *bsdf;
    else
        rsv_bsdf_vary_unbalanced(bsdf, m, varied);
}

#endif
