/// What single lobes of a point make of light from one direction. All of them together are rsv_bsdf_evaluate, but for the
/// refraction into bodies.
#ifndef RSV_LOBE_RESPONSE_H
#define RSV_LOBE_RESPONSE_H

#include "highlight.h"

/// What layers leave of a lobe of the base. @param cos_i unsigned
RSV_INLINE rsv_rgb rsv_layered(
    const rsv_highlight_lobes *l, rsv_rgb response, int spread, float cos_i)
{
    if (!l->layered) return response;
    return rgb_mul(response, rgb_mul(l->way[spread], rsv_bsdf_way(l->point.bsdf, spread, cos_i)));
}

/// Share of metal's spread in the balance of the interface: both sides of a sheet spread as white metal does.
RSV_INLINE float rsv_sheet_share(const rsv_bsdf *bsdf)
{
    return bsdf->solid ? 0 : bsdf->transmission;
}

/// Colour of what a facet of the base reflects.
RSV_INLINE rsv_rgb rsv_facet_color(const rsv_highlight_lobes *l, float cos_h, float cos_i)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_rgb metal = rgb_gray(0), interface = rgb_gray(0);
    if (bsdf->metallic > 0) {
        metal = rgb_scale(rsv_fresnel_schlick(bsdf->base_color, cos_h), bsdf->metallic);
        metal = rsv_layered(l, metal, RSV_SPREAD_METAL, cos_i);
    }
    if (bsdf->metallic < 1) {
        float cos_t, eta = rsv_bsdf_eta(bsdf, l->point.front);
        rsv_facet_choice choice = rsv_choose_at_facet(bsdf, cos_h, eta, &cos_t);
        interface = rgb_scale(choice.reflected, (1 - bsdf->metallic) * choice.reflect);
        if (l->layered) {
            float sheet = rsv_sheet_share(bsdf);
            rsv_rgb open = rsv_layered(l, interface, RSV_SPREAD_INTERFACE, cos_i);
            if (sheet > 0)
                open = rgb_mad(rgb_scale(open, 1 - sheet), sheet,
                    rsv_layered(l, interface, RSV_SPREAD_METAL, cos_i));
            interface = open;
        }
    }
    return rgb_add(metal, interface);
}

RSV_INLINE rsv_rgb rsv_base_response(const rsv_highlight_lobes *l, rsv_vec3 wi)
{
    const rsv_highlight_point *p = &l->point;
    rsv_vec3 h = v3_normalize(v3_add(wi, p->wo));
    return rgb_scale(rsv_facet_color(l, v3_dot(p->wo, h), v3_dot(p->normal, wi)),
        rsv_reflection_density(p->bsdf->alpha, wi, p->wo, p->normal, h));
}

/// @param wi on the far side
RSV_INLINE rsv_rgb rsv_sheet_response(const rsv_highlight_lobes *l, rsv_vec3 wi)
{
    const rsv_highlight_point *p = &l->point;
    const rsv_bsdf *bsdf = p->bsdf;
    rsv_vec3 above = v3_mad(wi, -2 * v3_dot(p->normal, wi), p->normal);
    rsv_vec3 h = v3_normalize(v3_add(above, p->wo));
    float cos_t, share = (1 - bsdf->metallic) * bsdf->transmission;
    rsv_facet_choice choice = rsv_choose_at_facet(bsdf, v3_dot(p->wo, h), bsdf->ior, &cos_t);
    float density = rsv_reflection_density(bsdf->alpha, above, p->wo, p->normal, h);
    rsv_rgb tint = rgb_mul(choice.transmitted, bsdf->base_color);
    return rsv_layered(l, rgb_scale(tint, share * (1 - choice.reflect) * density), RSV_SPREAD_METAL,
        v3_dot(p->normal, above));
}

/// Of what is scattered again, and of wide layers: times pi / cos.
RSV_INLINE rsv_rgb rsv_wide_color(const rsv_highlight_lobes *l, float cos_i)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_rgb sum = rgb_gray(0);
    if (!rgb_is_black(l->metal_again))
        sum = rsv_layered(l,
            rgb_scale(l->metal_again,
                rsv_bsdf_missing(bsdf, false, 0, cos_i) / rsv_bsdf_missing_mean(bsdf, false, 0)),
            RSV_SPREAD_METAL, cos_i);
    if (!rgb_is_black(l->glass_again)) {
        int here = bsdf->solid && !l->point.front;
        float missing = rsv_bsdf_missing(bsdf, bsdf->solid, here, cos_i) /
                        rsv_bsdf_missing_mean(bsdf, bsdf->solid, here);
        sum = rgb_add(sum, rsv_layered(l, rgb_scale(l->glass_again, missing),
                               bsdf->solid ? RSV_SPREAD_INTERFACE : RSV_SPREAD_METAL, cos_i));
    }
    return l->layered ? rsv_add_wide_layers(sum, bsdf, &l->wide, cos_i) : sum;
}

/// The same on the far side. @param cos_i unsigned
RSV_INLINE rsv_rgb rsv_passed_color(const rsv_highlight_lobes *l, float cos_i)
{
    const rsv_bsdf *bsdf = l->point.bsdf;
    rsv_rgb sum = rgb_gray(0);
    if (bsdf->passed > 0)
        sum = rgb_mul(rgb_scale(bsdf->passed_color, bsdf->passed),
            rgb_mul(rsv_bsdf_exit(bsdf, l->cos_o), rsv_bsdf_entry(bsdf, cos_i)));
    if (!rgb_is_black(l->glass_through))
        sum =
            rgb_add(sum, rsv_layered(l,
                             rgb_scale(l->glass_through, rsv_bsdf_missing(bsdf, false, 0, cos_i) /
                                                             rsv_bsdf_missing_mean(bsdf, false, 0)),
                             RSV_SPREAD_METAL, cos_i));
    return sum;
}

/// Response f |cos_i| of one lobe. @param wi unit, on the lobe's side
RSV_INLINE rsv_rgb rsv_lobe_response(const rsv_highlight_lobes *l, uint32_t kind, rsv_vec3 wi)
{
    const rsv_highlight_point *p = &l->point;
    float cos_i = fabsf(v3_dot(p->normal, wi));
    switch (kind) {
    case RSV_HIGHLIGHT_BASE:
        return rsv_base_response(l, wi);
    case RSV_HIGHLIGHT_COAT:
        return rgb_gray(p->bsdf->clearcoat * rsv_clearcoat_density(p->bsdf, wi, p->wo, p->normal));
    case RSV_HIGHLIGHT_WIDE:
        return rgb_scale(rsv_wide_color(l, cos_i), cos_i / RSV_PI);
    case RSV_HIGHLIGHT_SHEET:
        return rsv_sheet_response(l, wi);
    default:
        return rgb_scale(rsv_passed_color(l, cos_i), cos_i / RSV_PI);
    }
}

/// Whether a lobe takes light from the far side.
RSV_INLINE bool rsv_lobe_is_below(uint32_t kind)
{
    return kind == RSV_HIGHLIGHT_SHEET || kind == RSV_HIGHLIGHT_PASSED;
}

#endif
