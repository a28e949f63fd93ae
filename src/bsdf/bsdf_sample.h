/// Sampling of rsv_bsdf: facets are drawn as they are visible, reflect or transmit by their
/// reflectance, and count only if the light is not masked on its other leg; what is masked scatters
/// again. Every step has the probability of the physical event, so no weights arise but colours.
/// Included by bsdf.h alone.
#ifndef RSV_BSDF_SAMPLE_H
#define RSV_BSDF_SAMPLE_H

/// A draw in the making.
typedef struct rsv_bsdf_draw {
    const rsv_bsdf *bsdf;
    rsv_vec3 wo, n, h; ///< h: facet, = n if the interface is smooth
    bool front;
    rsv_random rest; ///< numbers for what seldom needs them
} rsv_bsdf_draw;

/// The next use of a number that lay below `split` (true) or above, stretched to [0, 1) again.
RSV_INLINE bool rsv_split_number(float *u, float split)
{
    bool below = *u < split;
    *u = below ? *u / split : (*u - split) / f_max(1 - split, 1e-7f);
    *u = f_min(*u, 0x1.fffffep-1f);
    return below;
}

RSV_INLINE uint32_t rsv_number_bits(float u) { return (uint32_t)(u * 0x1p24f); }

RSV_INLINE rsv_vec3 rsv_to_frame(rsv_vec3 w, rsv_vec3 n)
{
    rsv_vec3 t, b;
    v3_frame(n, &t, &b);
    return v3(v3_dot(w, t), v3_dot(w, b), v3_dot(w, n));
}
RSV_INLINE rsv_vec3 rsv_from_frame(rsv_vec3 w, rsv_vec3 n)
{
    rsv_vec3 t, b;
    v3_frame(n, &t, &b);
    return v3_normalize(v3_mad(v3_mad(v3_scale(n, w.z), w.x, t), w.y, b));
}

RSV_INLINE rsv_bsdf_event rsv_event(rsv_lobe lobe, rsv_vec3 direction, rsv_rgb weight)
{
    rsv_bsdf_event event = { lobe, direction, weight, 0 };
    return event;
}

RSV_INLINE void rsv_draw_facet(rsv_bsdf_draw *draw, float u1, float u2)
{
    if (draw->bsdf->alpha == 0) return;
    rsv_vec3 wo = rsv_to_frame(draw->wo, draw->n);
    draw->h = rsv_from_frame(rsv_ggx_sample_visible(wo, draw->bsdf->alpha, u1, u2), draw->n);
}

/// Whether light that met the facet leaves the microsurface towards `wi` unhindered.
RSV_INLINE bool rsv_leaves(rsv_bsdf_draw *draw, rsv_vec3 wi, bool reflected)
{
    float cos_i = v3_dot(draw->n, wi);
    if (reflected ? cos_i <= 0 : cos_i >= 0) return false;
    if (draw->bsdf->alpha == 0) return true;
    float visibility = rsv_ggx_visibility(v3_dot(draw->n, draw->wo), cos_i, draw->bsdf->alpha);
    return rsv_random_float(&draw->rest) < visibility;
}

/// Direction of density missing(cos) cos / (pi mean), by rejection. @param sign -1 = below the surface
RSV_INLINE rsv_vec3 rsv_draw_missing(rsv_bsdf_draw *draw, bool body, int side, float sign)
{
    rsv_vec3 local = v3(0, 0, 1);
    for (int tries = 0; tries < 4096; tries++) {
        float x = rsv_random_float(&draw->rest);
        local = rsv_square_to_cosine_hemisphere(x, rsv_random_float(&draw->rest));
        float missing = rsv_bsdf_missing(draw->bsdf, body, side, local.z);
        if (rsv_random_float(&draw->rest) < missing) break;
    }
    local.z *= sign;
    return rsv_from_frame(local, draw->n);
}

RSV_INLINE rsv_bsdf_event rsv_draw_metal(rsv_bsdf_draw *draw)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    rsv_vec3 wi = rsv_mirrored(draw->wo, draw->h);
    if (rsv_leaves(draw, wi, true)) {
        float cos_h = f_min(v3_dot(draw->wo, draw->h), 1);
        return rsv_event(RSV_LOBE_REFLECT, wi, rsv_fresnel_schlick(bsdf->base_color, cos_h));
    }
    if (bsdf->alpha == 0) return rsv_event(RSV_LOBE_NONE, wi, rgb_gray(0));
    return rsv_event(
        RSV_LOBE_REFLECT, rsv_draw_missing(draw, false, 0, 1), rsv_bsdf_metal_again(bsdf));
}

RSV_INLINE rsv_bsdf_event rsv_draw_glass_again(rsv_bsdf_draw *draw)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    int here = bsdf->solid && !draw->front, there = bsdf->solid && draw->front;
    if (bsdf->alpha == 0) return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    if (rsv_random_float(&draw->rest) < rsv_bsdf_missing_transmitted(bsdf, here))
        return rsv_event(
            RSV_LOBE_TRANSMIT, rsv_draw_missing(draw, bsdf->solid, there, -1), bsdf->base_color);
    return rsv_event(RSV_LOBE_REFLECT, rsv_draw_missing(draw, bsdf->solid, here, 1), rgb_gray(1));
}

RSV_INLINE rsv_bsdf_event rsv_draw_glass(rsv_bsdf_draw *draw, float u)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    float cos_t, cos_h = f_max(v3_dot(draw->wo, draw->h), 0);
    float eta = rsv_bsdf_eta(bsdf, draw->front);
    rsv_facet_choice choice = rsv_choose_at_facet(bsdf, cos_h, eta, &cos_t);
    rsv_vec3 mirrored = rsv_mirrored(draw->wo, draw->h), wi;
    if (u < choice.reflect)
        return rsv_leaves(draw, mirrored, true)
                   ? rsv_event(RSV_LOBE_REFLECT, mirrored, choice.reflected)
                   : rsv_draw_glass_again(draw);
    if (bsdf->solid)
        wi = rsv_refracted(draw->wo, draw->h, eta, cos_h, cos_t);
    else if (bsdf->alpha == 0)
        wi = v3_neg(draw->wo);
    else
        wi = v3_mad(mirrored, -2 * v3_dot(draw->n, mirrored), draw->n);
    if (!rsv_leaves(draw, wi, false)) return rsv_draw_glass_again(draw);
    return rsv_event(RSV_LOBE_TRANSMIT, wi, rgb_mul(choice.transmitted, bsdf->base_color));
}

/// Reflection off a facet of the coat; false where the light goes on into the base.
RSV_INLINE bool rsv_reflects_at_coat(rsv_bsdf_draw *draw, float u, rsv_bsdf_event *event)
{
    float cos_t, cos_h = f_max(v3_dot(draw->wo, draw->h), 0);
    float eta = rsv_bsdf_eta(draw->bsdf, draw->front);
    rsv_facet_choice choice = rsv_choose_at_facet(draw->bsdf, cos_h, eta, &cos_t);
    *event = rsv_event(RSV_LOBE_REFLECT, rsv_mirrored(draw->wo, draw->h), choice.reflected);
    return u < choice.reflect && rsv_leaves(draw, event->direction, true);
}

RSV_INLINE rsv_bsdf_event rsv_draw_coated(rsv_bsdf_draw *draw, float u)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    rsv_bsdf_event event;
    if (!rsv_bsdf_diffuses(bsdf, draw->front))
        return rsv_reflects_at_coat(draw, u, &event)
                   ? event
                   : rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    rsv_facet_choice coat = rsv_choose_at_coat(bsdf, v3_dot(draw->n, draw->wo));
    if (rsv_split_number(&u, coat.reflect)) {
        // the chance is the mean over facets, so a facet is wanted that does reflect
        for (int tries = 0; tries < 4096; tries++) {
            if (rsv_reflects_at_coat(draw, bsdf->alpha > 0 ? u : 0, &event)) return event;
            rsv_draw_facet(draw, rsv_random_float(&draw->rest), rsv_random_float(&draw->rest));
            u = rsv_random_float(&draw->rest);
        }
        return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    }
    event = rsv_event(RSV_LOBE_DIFFUSE, draw->n, coat.transmitted);
    event.pdf_solid_angle = bsdf->diffuse * (1 - coat.reflect);
    return event;
}

RSV_INLINE rsv_bsdf_event rsv_bsdf_draw_event(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, float u_lobe, float u1, float u2)
{
    float cos_o = v3_dot(n, wo);
    if (rsv_bsdf_is_black_side(bsdf, front) || cos_o <= 0)
        return rsv_event(RSV_LOBE_NONE, n, rgb_gray(0));
    if (bsdf->lambert) {
        rsv_bsdf_event diffuse = { RSV_LOBE_DIFFUSE, n, rgb_gray(1), 1 };
        return diffuse;
    }
    rsv_bsdf_draw draw = { bsdf, wo, n, n, front,
        rsv_random_from(rsv_number_bits(u_lobe), rsv_number_bits(u1), rsv_number_bits(u2)) };
    rsv_draw_facet(&draw, u1, u2);
    rsv_bsdf_event event = rsv_split_number(&u_lobe, bsdf->metallic) ? rsv_draw_metal(&draw)
                           : rsv_split_number(&u_lobe, bsdf->transmission)
                               ? rsv_draw_glass(&draw, u_lobe)
                               : rsv_draw_coated(&draw, u_lobe);
    bool directed = event.lobe == RSV_LOBE_REFLECT || event.lobe == RSV_LOBE_TRANSMIT;
    if (directed && bsdf->alpha > 0)
        event.pdf_solid_angle =
            rsv_bsdf_evaluate(bsdf, event.direction, wo, n, front, RSV_LOBES_ALL).pdf_solid_angle;
    return event;
}

RSV_INLINE rsv_bsdf_sample rsv_bsdf_sample_direction(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, float u_lobe, float u1, float u2)
{
    rsv_bsdf_event event = rsv_bsdf_draw_event(bsdf, wo, n, front, u_lobe, u1, u2);
    rsv_bsdf_sample sample = { event.lobe, event.direction, event.weight, event.pdf_solid_angle };
    if (event.lobe != RSV_LOBE_DIFFUSE) return sample;
    rsv_vec3 local = rsv_square_to_cosine_hemisphere(u1, u2);
    sample.direction = rsv_from_frame(local, n);
    rsv_rgb exitance = rgb_mul(bsdf->exitance_albedo, rsv_bsdf_entry(bsdf, local.z));
    sample.weight = rgb_mul(sample.weight, exitance);
    sample.pdf_solid_angle =
        bsdf->lambert ? local.z / RSV_PI : rsv_bsdf_pdf(bsdf, sample.direction, wo, n, front);
    return sample;
}

#endif
