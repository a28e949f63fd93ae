/// Sampling of rsv_bsdf. Facets are drawn by visibility, and reflect or transmit by their reflectance. Light that is
/// masked on its way out scatters again. Every step has the probability of the physical event, so weights are only
/// colours and, under layers, a(wi) / s(wo) of rough lobes (bsdf.h), with a mean of 1. Included only by bsdf.h.
#ifndef RSV_BSDF_SAMPLE_H
#define RSV_BSDF_SAMPLE_H

/// Rejection ends even where rounding leaves nothing to accept.
#define RSV_MOST_TRIES 4096

/// A draw in the making.
typedef struct rsv_bsdf_draw {
    const rsv_bsdf *bsdf;
    rsv_vec3 wo, n, h; ///< h: facet, = n if the interface is smooth
    bool front;
    bool brushed;    ///< off brushed metal
    bool ideal;      ///< the direction comes from an ideal lobe
    bool entered;    ///< it left through the coat diffusely: the weight already includes the layers
    int spread;      ///< RSV_SPREAD_* of the base's lobe
    rsv_random rest; ///< more random numbers, rarely needed
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

RSV_INLINE rsv_vec3 rsv_from_brush(const rsv_bsdf_draw *draw, rsv_vec3 w)
{
    rsv_vec3 x, y;
    rsv_brush_frame(draw->bsdf, draw->n, &x, &y);
    return v3_normalize(v3_mad(v3_mad(v3_scale(draw->n, w.z), w.x, x), w.y, y));
}

RSV_INLINE void rsv_draw_facet(rsv_bsdf_draw *draw, float u1, float u2)
{
    if (draw->bsdf->alpha == 0) return;
    if (draw->brushed) {
        rsv_vec3 wo = rsv_to_brush(draw->bsdf, draw->n, draw->wo);
        float along = draw->bsdf->brush_along, across = draw->bsdf->brush_across;
        draw->h = rsv_from_brush(draw, rsv_ggx_sample_visible_xy(wo, along, across, u1, u2));
        return;
    }
    rsv_vec3 wo = rsv_to_frame(draw->wo, draw->n);
    draw->h = rsv_from_frame(rsv_ggx_sample_visible(wo, draw->bsdf->alpha, u1, u2), draw->n);
}

RSV_INLINE float rsv_brushed_visibility(const rsv_bsdf *bsdf, rsv_vec3 n, rsv_vec3 wo, rsv_vec3 wi)
{
    return rsv_ggx_visibility_xy(rsv_to_brush(bsdf, n, wo), rsv_to_brush(bsdf, n, wi),
        bsdf->brush_along, bsdf->brush_across);
}

/// Whether light that met the facet leaves the microsurface towards `wi` unhindered.
RSV_INLINE bool rsv_leaves(rsv_bsdf_draw *draw, rsv_vec3 wi, bool reflected)
{
    float cos_i = v3_dot(draw->n, wi);
    if (reflected ? cos_i <= 0 : cos_i >= 0) return false;
    draw->ideal = draw->bsdf->alpha == 0;
    if (draw->ideal) return true;
    float visibility =
        draw->brushed ? rsv_brushed_visibility(draw->bsdf, draw->n, draw->wo, wi)
                      : rsv_ggx_visibility(v3_dot(draw->n, draw->wo), cos_i, draw->bsdf->alpha);
    return rsv_random_float(&draw->rest) < visibility;
}

/// Direction of density missing(cos) cos / (pi mean), by rejection. @param sign -1 = below the surface
RSV_INLINE rsv_vec3 rsv_draw_missing(rsv_bsdf_draw *draw, bool body, int side, float sign)
{
    rsv_vec3 local = v3(0, 0, 1);
    for (int tries = 0; tries < RSV_MOST_TRIES; tries++) {
        float x = rsv_random_float(&draw->rest);
        local = rsv_square_to_cosine_hemisphere(x, rsv_random_float(&draw->rest));
        float missing = draw->brushed ? rsv_brushed_missing(draw->bsdf, local)
                                      : rsv_bsdf_missing(draw->bsdf, body, side, local.z);
        if (rsv_random_float(&draw->rest) < missing) break;
    }
    local.z *= sign;
    return draw->brushed ? rsv_from_brush(draw, local) : rsv_from_frame(local, draw->n);
}

RSV_INLINE rsv_bsdf_event rsv_draw_metal(rsv_bsdf_draw *draw)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    rsv_vec3 wi = rsv_mirrored(draw->wo, draw->h);
    if (rsv_leaves(draw, wi, true)) {
        float cos_h = f_min(v3_dot(draw->wo, draw->h), 1);
        return rsv_event(RSV_LOBE_REFLECT, wi, rsv_bsdf_metal(bsdf, cos_h));
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
    draw->spread = bsdf->solid ? RSV_SPREAD_INTERFACE : RSV_SPREAD_METAL;
    if (bsdf->straight) {
        draw->ideal = true;
        return rsv_event(RSV_LOBE_TRANSMIT, v3_neg(draw->wo), bsdf->base_color);
    }
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

RSV_LARGE rsv_bsdf_event rsv_draw_coated(rsv_bsdf_draw *draw, float u)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    rsv_bsdf_event event;
    bool diffuses = rsv_bsdf_diffuses(bsdf, draw->front);
    draw->spread = RSV_SPREAD_INTERFACE;
    if (!diffuses && bsdf->passed == 0)
        return rsv_reflects_at_coat(draw, u, &event)
                   ? event
                   : rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    float cos_o = v3_dot(draw->n, draw->wo);
    float reflected = rsv_bsdf_coat_chance(bsdf, cos_o);
    if (rsv_split_number(&u, reflected)) {
        // the probability is a mean over facets, so draw until one does reflect
        for (int tries = 0; tries < RSV_MOST_TRIES; tries++) {
            if (rsv_reflects_at_coat(draw, bsdf->alpha > 0 ? u : 0, &event)) return event;
            float u2 = rsv_random_float(&draw->rest), u1 = rsv_random_float(&draw->rest);
            rsv_draw_facet(draw, u1, u2);
            u = rsv_random_float(&draw->rest);
        }
        return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    }
    event = rsv_event(RSV_LOBE_DIFFUSE, draw->n, rsv_bsdf_exit_weight(bsdf, cos_o));
    event.pdf_solid_angle = bsdf->diffuse * rsv_bsdf_exit_chance(bsdf, cos_o);
    if (rsv_bsdf_meets_layers(bsdf, draw->front))
        event.pdf_solid_angle *= rsv_bsdf_tilted_passage(bsdf, draw->wo, draw->n);
    float both = bsdf->diffuse + bsdf->passed;
    bool passes = bsdf->passed > 0 && u * both >= bsdf->diffuse;
    if (!passes && !diffuses) return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    if (passes) {
        float x = rsv_random_float(&draw->rest);
        rsv_vec3 local = rsv_square_to_cosine_hemisphere(x, rsv_random_float(&draw->rest));
        event.lobe = RSV_LOBE_TRANSMIT;
        draw->entered = true;
        event.direction = rsv_from_frame(v3(local.x, local.y, -local.z), draw->n);
        event.weight =
            rgb_mul(event.weight, rgb_mul(bsdf->passed_color, rsv_bsdf_entry(bsdf, local.z)));
    }
    return event;
}

/// Off the clear coat: by a facet that does reflect, as its chance was taken already.
RSV_INLINE rsv_bsdf_event rsv_draw_clearcoat(rsv_bsdf_draw *draw, float u1, float u2)
{
    float alpha = draw->bsdf->clearcoat_alpha, cos_t;
    rsv_vec3 own = rsv_bsdf_coat_normal(draw->bsdf, draw->wo, draw->n);
    rsv_vec3 wo = rsv_to_frame(draw->wo, own);
    draw->ideal = alpha == 0;
    if (draw->ideal)
        return rsv_event(RSV_LOBE_REFLECT, rsv_mirrored(draw->wo, draw->n), rgb_gray(1));
    for (int tries = 0; tries < RSV_MOST_TRIES; tries++) {
        rsv_vec3 h = rsv_ggx_sample_visible(wo, alpha, u1, u2), wi = rsv_mirrored(wo, h);
        float chance = rsv_fresnel_dielectric(f_min(v3_dot(wo, h), 1), RSV_CLEARCOAT_IOR, &cos_t);
        chance *= wi.z > 0 ? rsv_ggx_visibility(wo.z, wi.z, alpha) : 0;
        if (rsv_random_float(&draw->rest) < chance) {
            rsv_vec3 direction = rsv_from_frame(wi, own);
            bool above = v3_dot(direction, draw->n) > 0;
            return rsv_event(above ? RSV_LOBE_REFLECT : RSV_LOBE_NONE, direction, rgb_gray(1));
        }
        u1 = rsv_random_float(&draw->rest);
        u2 = rsv_random_float(&draw->rest);
    }
    return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
}

/// Cosine of density S cos: 1 - cos is a Beta variable of k + 1 and 2, a product of two powers.
RSV_INLINE float rsv_draw_sheen_cos(rsv_bsdf_draw *draw)
{
    float k = draw->bsdf->sheen_power, x = powf(1 - rsv_random_float(&draw->rest), 1 / (k + 1));
    return f_max(1 - x * powf(1 - rsv_random_float(&draw->rest), 1 / (k + 2)), 1e-6f);
}

/// Off the fibres, where the coat lets the light out.
RSV_INLINE rsv_bsdf_event rsv_draw_sheen(rsv_bsdf_draw *draw)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    float cos = rsv_draw_sheen_cos(draw), phi = 2 * RSV_PI * rsv_random_float(&draw->rest);
    for (int tries = 0; bsdf->clearcoat > 0 && tries < RSV_MOST_TRIES; tries++) {
        if (rsv_random_float(&draw->rest) >= rsv_bsdf_clearcoat_albedo(bsdf, cos)) break;
        cos = rsv_draw_sheen_cos(draw);
    }
    float sin = sqrtf(f_max(1 - cos * cos, 0));
    rsv_vec3 local = v3(sin * cosf(phi), sin * sinf(phi), cos);
    rsv_rgb tint = rgb_scale(bsdf->sheen, 1 / rgb_max(bsdf->sheen));
    return rsv_event(RSV_LOBE_REFLECT, rsv_from_frame(local, draw->n), tint);
}

RSV_LARGE rsv_bsdf_event rsv_draw_base(rsv_bsdf_draw *draw, float u, float u1, float u2)
{
    bool metal = rsv_split_number(&u, draw->bsdf->metallic);
    draw->brushed = metal && draw->bsdf->brushed;
    rsv_draw_facet(draw, u1, u2);
    if (metal) return rsv_draw_metal(draw);
    if (rsv_split_number(&u, draw->bsdf->transmission)) return rsv_draw_glass(draw, u);
    return rsv_draw_coated(draw, u);
}

/// Light from the base in `direction` that the layers transmit.
RSV_INLINE rsv_rgb rsv_left_by_layers(const rsv_bsdf_draw *draw, rsv_vec3 direction)
{
    float cos_o = v3_dot(draw->n, draw->wo), cos_i = v3_dot(draw->n, direction);
    bool refracted = draw->bsdf->solid && cos_i < 0;
    if (draw->ideal || refracted) return rsv_bsdf_passage(draw->bsdf, cos_o).light;
    if (draw->brushed) return rsv_bsdf_brushed_ways(draw->bsdf, direction, draw->wo, draw->n);
    return rsv_bsdf_both_ways(draw->bsdf, draw->spread, cos_i, cos_o);
}

/// The layers' lobes, or else the base's.
RSV_LARGE rsv_bsdf_event rsv_draw_layered(rsv_bsdf_draw *draw, float u, float u1, float u2)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    float cos_o = v3_dot(draw->n, draw->wo);
    float coat_cos = v3_dot(rsv_bsdf_coat_normal(bsdf, draw->wo, draw->n), draw->wo);
    float coat = rsv_bsdf_clearcoat_albedo(bsdf, coat_cos);
    if (rsv_split_number(&u, coat)) return rsv_draw_clearcoat(draw, u1, u2);
    if (rsv_split_number(&u, rgb_max(bsdf->sheen) * rsv_bsdf_sheen_albedo(bsdf, cos_o)))
        return rsv_draw_sheen(draw);
    rsv_bsdf_event event = rsv_draw_base(draw, u, u1, u2);
    if (event.lobe == RSV_LOBE_NONE || event.lobe == RSV_LOBE_DIFFUSE || draw->entered)
        return event;
    rsv_rgb left = rsv_left_by_layers(draw, event.direction);
    float chance = f_max(rsv_bsdf_passage(bsdf, cos_o).chance, 1e-9f);
    event.weight = rgb_mul(event.weight, rgb_scale(left, 1 / chance));
    return event;
}

/// Whether the base is rough glass that lets nothing in, such as a screen that is off: drawn by its chance, light that
/// it reflects would be one draw in 25.
RSV_INLINE bool rsv_bsdf_is_black_glass(const rsv_bsdf *bsdf, bool front)
{
    return front && bsdf->alpha > 0 && bsdf->metallic == 0 && bsdf->transmission == 1 &&
           !bsdf->layered && rgb_is_black(bsdf->base_color);
}

/// Shares of light that black glass reflects off one facet, and off several.
typedef struct rsv_glass_shares {
    float once, again;
} rsv_glass_shares;

RSV_INLINE rsv_glass_shares rsv_black_glass_shares(const rsv_bsdf *bsdf, float cos_o)
{
    rsv_glass_shares shares = { rsv_bsdf_coat_chance(bsdf, cos_o),
        rsv_bsdf_missing(bsdf, bsdf->solid, 0, cos_o) *
            (1 - rsv_bsdf_missing_transmitted(bsdf, 0)) };
    return shares;
}

RSV_INLINE float rsv_bsdf_specular_chance(const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front)
{
    float cos_o = f_max(v3_dot(n, wo), 0);
    if (rsv_bsdf_is_black_glass(bsdf, front)) {
        rsv_glass_shares shares = rsv_black_glass_shares(bsdf, cos_o);
        return shares.once + shares.again;
    }
    if (!rsv_bsdf_diffuses(bsdf, front) || bsdf->passed > 0) return 1;
    // in the order in which draws split u[0]: the diffuse lobe has its last part
    float diffuse =
        (1 - bsdf->metallic) * (1 - bsdf->transmission) * (1 - rsv_bsdf_coat_chance(bsdf, cos_o));
    if (rsv_bsdf_meets_layers(bsdf, front))
        diffuse *= rsv_bsdf_passage(bsdf, cos_o).chance * rsv_bsdf_tilted_passage(bsdf, wo, n);
    return 1 - diffuse;
}

RSV_INLINE rsv_bsdf_event rsv_bsdf_draw_event(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3])
{
    float cos_o = v3_dot(n, wo);
    if (rsv_bsdf_is_black_side(bsdf, front) || cos_o <= 0)
        return rsv_event(RSV_LOBE_NONE, n, rgb_gray(0));
    if (bsdf->lambert) {
        rsv_bsdf_event diffuse = { RSV_LOBE_DIFFUSE, n, rgb_gray(1), 1 };
        return diffuse;
    }
    rsv_bsdf_draw draw = { bsdf, wo, n, n, front, false, false, false, RSV_SPREAD_METAL,
        rsv_random_from(rsv_number_bits(u[0]), rsv_number_bits(u[1]), rsv_number_bits(u[2])) };
    rsv_bsdf_event event = rsv_bsdf_meets_layers(bsdf, front)
                               ? rsv_draw_layered(&draw, u[0], u[1], u[2])
                               : rsv_draw_base(&draw, u[0], u[1], u[2]);
    if (event.lobe == RSV_LOBE_DIFFUSE) return event;
    // 0 where the direction came from an ideal lobe, as no density is found there but by accident
    event.pdf_solid_angle = event.lobe == RSV_LOBE_NONE || draw.ideal
                                ? 0
                                : rsv_bsdf_pdf(bsdf, event.direction, wo, n, front);
    return event;
}

/// The coat alone, weighted by the reflectance of facets instead of drawn by it, because most do not reflect.
RSV_INLINE rsv_bsdf_event rsv_draw_weighted_coat(rsv_bsdf_draw *draw, float u1, float u2)
{
    const rsv_bsdf *bsdf = draw->bsdf;
    rsv_draw_facet(draw, u1, u2);
    float cos_t, cos_h = f_max(v3_dot(draw->wo, draw->h), 0);
    rsv_vec3 wi = rsv_mirrored(draw->wo, draw->h);
    float cos_i = v3_dot(draw->n, wi);
    if (cos_i <= 0) return rsv_event(RSV_LOBE_NONE, draw->n, rgb_gray(0));
    rsv_facet_choice choice =
        rsv_choose_at_facet(bsdf, cos_h, rsv_bsdf_eta(bsdf, draw->front), &cos_t);
    float visible = rsv_ggx_visibility(v3_dot(draw->n, draw->wo), cos_i, bsdf->alpha);
    return rsv_event(RSV_LOBE_REFLECT, wi, rgb_scale(choice.reflected, choice.reflect * visible));
}

/// Reflection of black glass.
RSV_INLINE rsv_bsdf_event rsv_draw_black_glass(
    rsv_bsdf_draw *draw, float u_lobe, float u1, float u2)
{
    rsv_glass_shares shares = rsv_black_glass_shares(draw->bsdf, v3_dot(draw->n, draw->wo));
    float both = shares.once + shares.again;
    if (u_lobe * both < shares.again)
        return rsv_event(
            RSV_LOBE_REFLECT, rsv_draw_missing(draw, draw->bsdf->solid, 0, 1), rgb_gray(both));
    rsv_bsdf_event event = rsv_draw_weighted_coat(draw, u1, u2);
    event.weight = rgb_scale(event.weight, both / f_max(shares.once, 1e-9f));
    return event;
}

RSV_LARGE rsv_bsdf_event rsv_bsdf_draw_specular(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3])
{
    float chance = rsv_bsdf_specular_chance(bsdf, wo, n, front);
    bool faces = v3_dot(n, wo) > 0, black_glass = faces && rsv_bsdf_is_black_glass(bsdf, front);
    bool coat_alone = faces && chance < 1 && bsdf->alpha > 0 && bsdf->metallic == 0 &&
                      bsdf->transmission == 0 && !rsv_bsdf_meets_layers(bsdf, front);
    rsv_bsdf_event event;
    if (coat_alone || black_glass) {
        rsv_bsdf_draw draw = { bsdf, wo, n, n, front, false, false, false, 0,
            rsv_random_from(rsv_number_bits(u[0]), rsv_number_bits(u[1]), rsv_number_bits(u[2])) };
        event = black_glass ? rsv_draw_black_glass(&draw, u[0], u[1], u[2])
                            : rsv_draw_weighted_coat(&draw, u[1], u[2]);
        if (event.lobe != RSV_LOBE_NONE)
            event.pdf_solid_angle = rsv_bsdf_pdf(bsdf, event.direction, wo, n, front);
        return event;
    }
    const float among[3] = { chance * u[0], u[1], u[2] };
    event = rsv_bsdf_draw_event(bsdf, wo, n, front, among);
    event.weight = rgb_scale(event.weight, chance);
    return event;
}

RSV_INLINE rsv_bsdf_sample rsv_bsdf_sample_direction(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3])
{
    rsv_bsdf_event event = rsv_bsdf_draw_event(bsdf, wo, n, front, u);
    rsv_bsdf_sample sample = { event.lobe, event.direction, event.weight, event.pdf_solid_angle };
    if (event.lobe != RSV_LOBE_DIFFUSE) return sample;
    rsv_vec3 local = rsv_square_to_cosine_hemisphere(u[1], u[2]);
    sample.direction = rsv_from_frame(local, n);
    rsv_rgb exitance = rgb_mul(bsdf->base_color, rsv_bsdf_entry(bsdf, local.z));
    sample.weight = rgb_mul(sample.weight, exitance);
    sample.pdf_solid_angle =
        bsdf->lambert ? local.z / RSV_PI : rsv_bsdf_pdf(bsdf, sample.direction, wo, n, front);
    return sample;
}

#endif
