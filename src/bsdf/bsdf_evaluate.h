/// Values and densities of rsv_bsdf's lobes. Each lobe is its sampling density times a weight, so that one sum gives
/// both. Included only by bsdf.h.
#ifndef RSV_BSDF_EVALUATE_H
#define RSV_BSDF_EVALUATE_H

/// Ideal branches of the base, as if there were no layers.
RSV_INLINE void rsv_set_ideal_branches(
    rsv_bsdf_branches *branches, const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    float cos_o = f_min(f_max(v3_dot(n, wo), 0), 1), cos_t;
    float eta = rsv_bsdf_eta(bsdf, front), dielectric = 1 - bsdf->metallic;
    rsv_facet_choice choice = rsv_choose_at_facet(bsdf, cos_o, eta, &cos_t);
    branches->reflect = rgb_mad(rgb_scale(choice.reflected, dielectric * choice.reflect),
        bsdf->metallic, rsv_bsdf_metal(bsdf, cos_o));
    branches->transmit = rgb_scale(rgb_mul(choice.transmitted, bsdf->base_color),
        dielectric * bsdf->transmission * (1 - choice.reflect));
    if (bsdf->solid) branches->transmit_direction = rsv_refracted(wo, n, eta, cos_o, cos_t);
}

RSV_INLINE rsv_bsdf_branches rsv_bsdf_evaluate_branches(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    rsv_bsdf_branches branches = { rgb_gray(0), rgb_gray(0), rgb_gray(0), n, v3_neg(wo), false };
    if (rsv_bsdf_is_black_side(bsdf, front)) return branches;
    if (bsdf->lambert) {
        branches.diffuse = rgb_gray(1);
        return branches;
    }
    float cos_o = f_min(f_max(v3_dot(n, wo), 0), 1);
    bool layers = rsv_bsdf_meets_layers(bsdf, front);
    float tilted = layers ? rsv_bsdf_tilted_passage(bsdf, wo, n) : 1;
    branches.rough = bsdf->rough;
    branches.reflect_direction = rsv_mirrored(wo, n);
    if (rsv_bsdf_diffuses(bsdf, front))
        branches.diffuse = rgb_scale(rsv_bsdf_exit(bsdf, cos_o), bsdf->diffuse * tilted);
    if (bsdf->alpha == 0)
        rsv_set_ideal_branches(&branches, bsdf, wo, n, front);
    else if (bsdf->straight)
        branches.transmit = rgb_scale(bsdf->base_color, (1 - bsdf->metallic) * bsdf->transmission);
    if (!layers) return branches;
    rsv_rgb left = rgb_scale(rsv_bsdf_passage(bsdf, cos_o).light, tilted);
    branches.reflect = rgb_mul(branches.reflect, left);
    branches.transmit = rgb_mul(branches.transmit, left);
    if (bsdf->clearcoat_alpha == 0)
        branches.reflect =
            rgb_add(branches.reflect, rgb_gray(rsv_bsdf_clearcoat_albedo(bsdf, cos_o)));
    return branches;
}

RSV_INLINE void rsv_add_metal(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_i = v3_dot(n, wi), share = bsdf->metallic;
    if (share == 0 || cos_i <= 0) return;
    rsv_vec3 h = v3_normalize(v3_add(wi, wo));
    rsv_add_term(
        value, share * rsv_metal_density(bsdf, wi, wo, n, h), rsv_bsdf_metal(bsdf, v3_dot(wo, h)));
    float missing = rsv_bsdf_metal_missing(bsdf, n, wo) * rsv_bsdf_metal_missing(bsdf, n, wi) /
                    rsv_bsdf_metal_missing_mean(bsdf);
    rsv_add_term(value, share * missing * cos_i / RSV_PI, rsv_bsdf_metal_again(bsdf));
}

/// Reflection at the dielectric interface, for coats and glass.
RSV_INLINE void rsv_add_interface_reflection(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    float share = 1 - bsdf->metallic, cos_t;
    if (share == 0 || v3_dot(n, wi) <= 0) return;
    rsv_vec3 h = v3_normalize(v3_add(wi, wo));
    rsv_facet_choice choice =
        rsv_choose_at_facet(bsdf, v3_dot(wo, h), rsv_bsdf_eta(bsdf, front), &cos_t);
    rsv_add_term(value, share * choice.reflect * rsv_reflection_density(bsdf->alpha, wi, wo, n, h),
        choice.reflected);
}

/// A body's rough surface (Walter et al. 2007); wi on the far side.
RSV_INLINE void rsv_add_refraction(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    float eta = rsv_bsdf_eta(bsdf, front), share = (1 - bsdf->metallic) * bsdf->transmission, cos_t;
    rsv_vec3 h = v3_mad(wo, eta, wi);
    if (v3_dot(h, n) < 0) h = v3_neg(h);
    float length = v3_length(h);
    if (length < 1e-6f) return;
    h = v3_scale(h, 1 / length);
    float cos_oh = v3_dot(wo, h), cos_ih = v3_dot(wi, h);
    if (cos_oh <= 0 || cos_ih >= 0) return;
    rsv_facet_choice choice = rsv_choose_at_facet(bsdf, cos_oh, eta, &cos_t);
    float jacobian = eta * eta * -cos_ih / (length * length);
    float density = rsv_ggx_visible_pdf(n, h, wo, bsdf->alpha) * jacobian *
                    rsv_ggx_visibility(v3_dot(n, wo), v3_dot(n, wi), bsdf->alpha);
    rsv_add_term(value, share * (1 - choice.reflect) * density,
        rgb_mul(choice.transmitted, bsdf->base_color));
}

/// A thin rough sheet: refracted twice, light leaves as if reflected, on the other side.
RSV_INLINE void rsv_add_sheet_transmission(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float share = (1 - bsdf->metallic) * bsdf->transmission, cos_t;
    rsv_vec3 above = v3_mad(wi, -2 * v3_dot(n, wi), n), h = v3_normalize(v3_add(above, wo));
    rsv_facet_choice choice = rsv_choose_at_facet(bsdf, v3_dot(wo, h), bsdf->ior, &cos_t);
    rsv_add_term(value,
        share * (1 - choice.reflect) * rsv_reflection_density(bsdf->alpha, above, wo, n, h),
        rgb_mul(choice.transmitted, bsdf->base_color));
}

/// Multiple scattering in glass.
RSV_INLINE void rsv_add_glass_again(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, float cos_i, float cos_o, bool front)
{
    int here = bsdf->solid && !front, there = cos_i > 0 ? here : bsdf->solid && front;
    float transmitted = rsv_bsdf_missing_transmitted(bsdf, here);
    float density = rsv_bsdf_missing(bsdf, bsdf->solid, here, cos_o) *
                    rsv_bsdf_missing(bsdf, bsdf->solid, there, cos_i) * fabsf(cos_i) /
                    (RSV_PI * rsv_bsdf_missing_mean(bsdf, bsdf->solid, there));
    float share = (1 - bsdf->metallic) * bsdf->transmission;
    rsv_add_term(value, share * density * (cos_i > 0 ? 1 - transmitted : transmitted),
        cos_i > 0 ? rgb_gray(1) : bsdf->base_color);
}

RSV_INLINE void rsv_add_diffuse(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, float cos_i, float cos_o)
{
    if (cos_i <= 0) return;
    rsv_rgb weight = rgb_mul(rsv_bsdf_exit_weight(bsdf, cos_o), rsv_bsdf_entry(bsdf, cos_i));
    rsv_add_term(value, bsdf->diffuse * rsv_bsdf_exit_chance(bsdf, cos_o) * cos_i / RSV_PI,
        rgb_mul(weight, bsdf->base_color));
}

/// Diffuse light that leaves a thin sheet on the other side.
RSV_INLINE void rsv_add_passed(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, float cos_i, float cos_o)
{
    if (cos_i >= 0 || bsdf->passed == 0) return;
    rsv_rgb weight = rgb_mul(rsv_bsdf_exit_weight(bsdf, cos_o), rsv_bsdf_entry(bsdf, -cos_i));
    rsv_add_term(value, bsdf->passed * rsv_bsdf_exit_chance(bsdf, cos_o) * -cos_i / RSV_PI,
        rgb_mul(weight, bsdf->passed_color));
}

/// Adds lobes of the base that the layers leave `factor` of. @param chance of drawing them
RSV_INLINE void rsv_add_dimmed(
    rsv_bsdf_value *value, const rsv_bsdf_value *base, float chance, rsv_rgb factor)
{
    value->response = rgb_add(value->response, rgb_mul(base->response, factor));
    value->pdf_solid_angle += chance * base->pdf_solid_angle;
}

/// The base's lobes that are neither ideal nor diffuse: of metal, off the interface, the rest of glass.
typedef struct rsv_rough_base {
    rsv_bsdf_value metal, interface, glass;
} rsv_rough_base;

RSV_LARGE rsv_rough_base rsv_evaluate_rough_base(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    rsv_bsdf_value none = { rgb_gray(0), 0 };
    rsv_rough_base base = { none, none, none };
    float cos_o = v3_dot(n, wo), cos_i = v3_dot(n, wi);
    rsv_add_metal(&base.metal, bsdf, wi, wo, n);
    rsv_add_interface_reflection(&base.interface, bsdf, wi, wo, n, front);
    if (bsdf->transmission == 0 || bsdf->metallic == 1 || bsdf->straight) return base;
    if (cos_i < 0 && bsdf->solid) rsv_add_refraction(&base.glass, bsdf, wi, wo, n, front);
    if (cos_i < 0 && !bsdf->solid) rsv_add_sheet_transmission(&base.glass, bsdf, wi, wo, n);
    rsv_add_glass_again(&base.glass, bsdf, cos_i, cos_o, front);
    return base;
}

/// The two sides of a sheet together spread light as white metal does.
RSV_INLINE void rsv_add_layered_base(rsv_bsdf_value *value, const rsv_bsdf *bsdf,
    const rsv_rough_base *base, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_i = v3_dot(n, wi), cos_o = v3_dot(n, wo);
    rsv_layer_passage passage = rsv_bsdf_passage(bsdf, cos_o);
    float sheet = bsdf->solid ? 0 : bsdf->transmission;
    rsv_rgb metal = rgb_gray(0), interface = rgb_gray(0);
    if (bsdf->metallic > 0 || sheet > 0)
        metal = rsv_bsdf_both_ways(bsdf, RSV_SPREAD_METAL, cos_i, cos_o);
    if (bsdf->metallic < 1)
        interface = rsv_bsdf_both_ways(bsdf, RSV_SPREAD_INTERFACE, cos_i, cos_o);
    rsv_rgb body = cos_i < 0 ? passage.light : interface;
    rsv_add_dimmed(value, &base->metal, passage.chance,
        bsdf->brushed ? rsv_bsdf_brushed_ways(bsdf, wi, wo, n) : metal);
    rsv_add_dimmed(value, &base->interface, passage.chance,
        rgb_mad(interface, sheet, rgb_sub(metal, interface)));
    rsv_add_dimmed(value, &base->glass, passage.chance, bsdf->solid ? body : metal);
}

RSV_INLINE void rsv_add_rough_base(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    rsv_rough_base base = rsv_evaluate_rough_base(bsdf, wi, wo, n, front);
    if (rsv_bsdf_meets_layers(bsdf, front)) {
        rsv_add_layered_base(value, bsdf, &base, wi, wo, n);
        return;
    }
    rsv_add_dimmed(value, &base.metal, 1, rgb_gray(1));
    rsv_add_dimmed(value, &base.interface, 1, rgb_gray(1));
    rsv_add_dimmed(value, &base.glass, 1, rgb_gray(1));
}

RSV_INLINE void rsv_scale_value(rsv_bsdf_value *value, float factor)
{
    value->response = rgb_scale(value->response, factor);
    value->pdf_solid_angle *= factor;
}

RSV_LARGE rsv_bsdf_value rsv_bsdf_evaluate(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front, rsv_lobe_set lobes)
{
    rsv_bsdf_value value = { rgb_gray(0), 0 };
    float cos_o = v3_dot(n, wo), cos_i = v3_dot(n, wi);
    if (rsv_bsdf_is_black_side(bsdf, front) || cos_o <= 0 || cos_i == 0) return value;
    bool rough = (lobes & RSV_LOBES_ROUGH) && bsdf->rough;
    bool layers = rsv_bsdf_meets_layers(bsdf, front);
    if (rough) {
        if (bsdf->alpha > 0) rsv_add_rough_base(&value, bsdf, wi, wo, n, front);
        if (layers) rsv_add_sheen(&value, bsdf, cos_i, cos_o);
        rsv_add_passed(&value, bsdf, cos_i, cos_o);
    }
    if ((lobes & RSV_LOBES_DIFFUSE) && rsv_bsdf_diffuses(bsdf, front))
        rsv_add_diffuse(&value, bsdf, cos_i, cos_o);
    if (layers && bsdf->tilted) rsv_scale_value(&value, rsv_bsdf_tilted_passage(bsdf, wo, n));
    if (rough && layers) rsv_add_clearcoat(&value, bsdf, wi, wo, n);
    return value;
}

RSV_INLINE rsv_rgb rsv_bsdf_eval(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    float cos_i = fabsf(v3_dot(n, wi));
    if (cos_i == 0) return rgb_gray(0);
    rsv_rgb response = rsv_bsdf_evaluate(bsdf, wi, wo, n, front, RSV_LOBES_ALL).response;
    return rgb_scale(response, 1 / cos_i);
}

RSV_INLINE float rsv_bsdf_pdf(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    return rsv_bsdf_evaluate(bsdf, wi, wo, n, front, RSV_LOBES_ALL).pdf_solid_angle;
}

#endif
