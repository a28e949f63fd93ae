/// The interface between media, which the lobes of rsv_bsdf share. Included only by bsdf.h.
#ifndef RSV_BSDF_INTERFACE_H
#define RSV_BSDF_INTERFACE_H

RSV_INLINE rsv_rgb rsv_one_minus(rsv_rgb a) { return rgb(1 - a.r, 1 - a.g, 1 - a.b); }

RSV_INLINE rsv_vec3 rsv_mirrored(rsv_vec3 wo, rsv_vec3 h)
{
    return v3_normalize(v3_sub(v3_scale(h, 2 * v3_dot(h, wo)), wo));
}

RSV_INLINE rsv_vec3 rsv_bsdf_specular_normal(rsv_vec3 shading, rsv_vec3 geometric, rsv_vec3 wo)
{
    bool above = v3_dot(shading, wo) > 0 && v3_dot(geometric, rsv_mirrored(wo, shading)) > 0;
    return above ? shading : geometric;
}

/// Snell's law; `eta` is the far side's ior over that of wo's side.
RSV_INLINE rsv_vec3 rsv_refracted(rsv_vec3 wo, rsv_vec3 h, float eta, float cos_o, float cos_t)
{
    return v3_normalize(v3_mad(v3_scale(wo, -1 / eta), cos_o / eta - cos_t, h));
}

/// The far side's ior over that of wo's side, as reflection sees it: a thin sheet is seen from outside.
RSV_INLINE float rsv_bsdf_eta(const rsv_bsdf *bsdf, bool front)
{
    return bsdf->solid && !front ? 1 / bsdf->ior : bsdf->ior;
}

/// Whether light scatters diffusely on this side: inside a body and behind one-sided surfaces not.
RSV_INLINE bool rsv_bsdf_diffuses(const rsv_bsdf *bsdf, bool front)
{
    return bsdf->diffuse > 0 && (front || (bsdf->double_sided && !bsdf->solid));
}

/// Whether this side absorbs all light, independently of the lobes.
RSV_INLINE bool rsv_bsdf_is_black_side(const rsv_bsdf *bsdf, bool front)
{
    return !front && !bsdf->double_sided && bsdf->transmission == 0 && bsdf->passed == 0;
}

/// Reflectance at one facet: its probability, and the remaining weight per channel.
typedef struct rsv_facet_choice {
    float reflect;       ///< probability
    rsv_rgb reflected;   ///< weight if it reflects
    rsv_rgb transmitted; ///< weight if it does not
} rsv_facet_choice;

RSV_INLINE rsv_facet_choice rsv_choice_of(rsv_rgb tint, float reflectance)
{
    float largest = f_max(rgb_max(tint), 1e-6f), p = largest * reflectance;
    rsv_facet_choice choice = { p, rgb_scale(tint, 1 / largest), rgb_gray(0) };
    if (p < 1)
        choice.transmitted = rgb_scale(rsv_one_minus(rgb_scale(tint, reflectance)), 1 / (1 - p));
    return choice;
}

/// Any reflectance; of rough surfaces the probability is linear between places of the table, as the reflectance is.
RSV_INLINE rsv_facet_choice rsv_choice_of_light(rsv_rgb reflected, float probability)
{
    rsv_facet_choice choice = { probability, rgb_gray(1), rgb_gray(0) };
    if (probability > 0) choice.reflected = rgb_scale(reflected, 1 / probability);
    if (probability < 1)
        choice.transmitted = rgb_scale(rsv_one_minus(reflected), 1 / (1 - probability));
    return choice;
}

// ---- thin films ---------------------------------------------------------------------------------

/// Reflectance of an interface of which a share lies under the film. @param cos outside
RSV_LARGE rsv_rgb rsv_bsdf_filmed(const rsv_bsdf *bsdf, int kind, float cos)
{
    float share = bsdf->film.share, cos_t;
    rsv_rgb bare, under;
    if (kind == RSV_FILMED_METAL) {
        bare = rsv_fresnel_schlick(bsdf->base_color, cos);
        under = rsv_film_reflectance_of_metal(bsdf->tables, bsdf->film, bsdf->base_color, cos);
        return rgb_mad(rgb_scale(bare, 1 - share), share, under);
    }
    bare = rgb_gray(rsv_fresnel_dielectric(cos, bsdf->ior, &cos_t));
    under = rsv_film_reflectance(bsdf->tables, bsdf->film, bsdf->ior, cos);
    return rgb_mul(bsdf->specular_tint, rgb_mad(rgb_scale(bare, 1 - share), share, under));
}

/// Reflectance of a facet.
typedef struct rsv_facet_light {
    rsv_rgb reflected;
    float largest; ///< of the channels; of a rough surface interpolated, and so no less than that
} rsv_facet_light;

RSV_INLINE rsv_facet_light rsv_filmed_facet(const rsv_bsdf *bsdf, int kind, float cos)
{
    rsv_facet_light light;
    cos = f_min(f_max(cos, 0), 1);
    if (bsdf->alpha == 0) {
        light.reflected = rsv_bsdf_filmed(bsdf, kind, cos);
        light.largest = rgb_max(light.reflected);
        return light;
    }
    rsv_table_place at = rsv_facet_cos(cos);
    rsv_rgb low = bsdf->filmed[kind][at.index], high = bsdf->filmed[kind][at.index + 1];
    light.reflected = rgb_mad(low, at.weight, rgb_sub(high, low));
    light.largest = rgb_max(low) + at.weight * (rgb_max(high) - rgb_max(low));
    return light;
}

/// Directional albedo of the filmed coat.
RSV_LARGE rsv_facet_light rsv_filmed_albedo(const rsv_bsdf *bsdf, float cos)
{
    if (bsdf->alpha == 0) return rsv_filmed_facet(bsdf, RSV_FILMED_COAT, cos);
    rsv_table_place at = rsv_table_cos(cos);
    rsv_facet_light sum = { rgb_gray(0), 0 };
    RSV_ROLLED
    for (int k = 0; k < RSV_FACET_COS; k++) {
        rsv_rgb facet = bsdf->filmed[RSV_FILMED_COAT][k];
        float share = rsv_table_albedo(bsdf->tables->facet[k], bsdf->alpha_place, at);
        sum.reflected = rgb_mad(sum.reflected, share, facet);
        sum.largest += share * rgb_max(facet);
    }
    return sum;
}

/// Hemispherical mean of the reflectance. @param alpha of the facets; that of a smooth surface: as if there was one
/// only
RSV_INLINE rsv_rgb rsv_filmed_mean(const rsv_bsdf *bsdf, int kind, rsv_table_place alpha)
{
    rsv_rgb sum = rgb_gray(0);
    RSV_ROLLED
    for (int k = 0; k < RSV_FACET_COS; k++)
        sum =
            rgb_mad(sum, rsv_table_line(bsdf->tables->facet_mean[k], alpha), bsdf->filmed[kind][k]);
    return sum;
}

// ---- the interface ------------------------------------------------------------------------------

/// Reflectance of a metal's facet.
RSV_INLINE rsv_rgb rsv_bsdf_metal(const rsv_bsdf *bsdf, float cos)
{
    if (bsdf->film.share == 0) return rsv_fresnel_schlick(bsdf->base_color, cos);
    return rsv_filmed_facet(bsdf, RSV_FILMED_METAL, cos).reflected;
}

/// A weakened or tinted interface still reflects totally: nothing else can become of that light.
RSV_INLINE rsv_facet_choice rsv_choose_at_facet(
    const rsv_bsdf *bsdf, float cos_h, float eta, float *cos_t)
{
    float fresnel = rsv_fresnel_dielectric(f_min(cos_h, 1), eta, cos_t);
    bool total = fresnel >= 1 && bsdf->solid;
    if (bsdf->film.share > 0 && !total) {
        rsv_facet_light light = rsv_filmed_facet(
            bsdf, RSV_FILMED_COAT, eta < 1 ? *cos_t : cos_h); // the same from both sides
        return rsv_choice_of_light(light.reflected, light.largest);
    }
    return rsv_choice_of(total ? rgb_gray(1) : bsdf->specular_tint, fresnel);
}

/// R(w): directional albedo of the coat, seen from outside.
RSV_INLINE float rsv_bsdf_interface_albedo(const rsv_bsdf *bsdf, float cos)
{
    float cos_t;
    cos = f_min(f_max(cos, 0), 1);
    if (bsdf->alpha == 0) return rsv_fresnel_dielectric(cos, bsdf->ior, &cos_t);
    return rsv_table_dielectric(
        bsdf->tables->reflected, bsdf->eta_place, bsdf->alpha_place, rsv_table_cos(cos));
}

/// s R(w).
RSV_INLINE rsv_rgb rsv_bsdf_coat_albedo(const rsv_bsdf *bsdf, float cos)
{
    if (bsdf->film.share > 0) return rsv_filmed_albedo(bsdf, cos).reflected;
    return rgb_scale(bsdf->specular_tint, rsv_bsdf_interface_albedo(bsdf, cos));
}

/// Chance of reflection off the coat.
RSV_INLINE float rsv_bsdf_coat_chance(const rsv_bsdf *bsdf, float cos)
{
    if (bsdf->film.share > 0) return rsv_filmed_albedo(bsdf, cos).largest;
    return rgb_max(bsdf->specular_tint) * rsv_bsdf_interface_albedo(bsdf, cos);
}

RSV_INLINE void rsv_add_term(rsv_bsdf_value *value, float density, rsv_rgb weight)
{
    value->response = rgb_mad(value->response, density, weight);
    value->pdf_solid_angle += density;
}

/// Density of reflection off a white microsurface; the masked part is left out. @param h half vector
RSV_INLINE float rsv_reflection_density(
    float alpha, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, rsv_vec3 h)
{
    float cos_o = v3_dot(n, wo), cos_i = v3_dot(n, wi);
    float cos_h = f_max(v3_dot(wo, h), 1e-6f);
    return rsv_ggx_visible_pdf(n, h, wo, alpha) * rsv_ggx_visibility(cos_o, cos_i, alpha) /
           (4 * cos_h);
}

// ---- multiple scattering -------------------------------------------------------------------------

/// Means below this come from rounding of the tables.
#define RSV_LEAST_MISSING 1e-5f

/// Energy that single scattering leaves over. A body's surface has two sides, 0 outside and 1 inside;
/// metals and thin sheets have one.
RSV_INLINE float rsv_bsdf_missing(const rsv_bsdf *bsdf, bool body, int side, float cos)
{
    rsv_table_place at = rsv_table_cos(f_min(fabsf(cos), 1));
    float missing = body ? rsv_table_dielectric(
                               bsdf->tables->missing[side], bsdf->eta_place, bsdf->alpha_place, at)
                         : rsv_table_albedo(bsdf->tables->conductor_missing, bsdf->alpha_place, at);
    return f_max(missing, 0);
}

RSV_INLINE float rsv_bsdf_missing_mean(const rsv_bsdf *bsdf, bool body, int side)
{
    float mean =
        body ? rsv_table_mean(bsdf->tables->missing_mean[side], bsdf->eta_place, bsdf->alpha_place)
             : rsv_table_line(bsdf->tables->conductor_missing_mean, bsdf->alpha_place);
    return f_max(mean, RSV_LEAST_MISSING);
}

/// Fraction of glass's multiple scattering that is transmitted. Light in balance on both sides of a body stays so if
/// inside fraction * inside mean * ior^2 = outside fraction * outside mean.
RSV_INLINE float rsv_bsdf_missing_transmitted(const rsv_bsdf *bsdf, int side)
{
    float passed = 1 - bsdf->smooth_mean;
    if (!bsdf->solid) return 1 - bsdf->smooth_mean * rgb_max(bsdf->specular_tint);
    float outside = rsv_bsdf_missing_mean(bsdf, true, 0);
    float inside = rsv_bsdf_missing_mean(bsdf, true, 1);
    float share = passed * f_min(1, inside / outside);
    return side == 0 ? share : share * outside / (bsdf->ior * bsdf->ior * inside);
}

// ---- brushed metal ------------------------------------------------------------------------------

/// Axes of the surface: along the brush, and across.
RSV_INLINE void rsv_brush_frame(const rsv_bsdf *bsdf, rsv_vec3 n, rsv_vec3 *x, rsv_vec3 *y)
{
    rsv_vec3 along = v3_mad(bsdf->brush, -v3_dot(bsdf->brush, n), n);
    if (v3_dot(along, along) < 1e-8f) {
        v3_frame(n, x, y);
        return;
    }
    *x = v3_normalize(along);
    *y = v3_cross(n, *x);
}

RSV_INLINE rsv_vec3 rsv_to_brush(const rsv_bsdf *bsdf, rsv_vec3 n, rsv_vec3 w)
{
    rsv_vec3 x, y;
    rsv_brush_frame(bsdf, n, &x, &y);
    return v3(v3_dot(w, x), v3_dot(w, y), v3_dot(w, n));
}

RSV_INLINE float rsv_brushed_entry(
    const rsv_brushed_rows rows, rsv_table_place turn, rsv_table_place cos)
{
    float low = rsv_table_line(rows[turn.index], cos);
    return low + turn.weight * (rsv_table_line(rows[turn.index + 1], cos) - low);
}

/// rsv_bsdf_missing of brushed metal. @param w in the frame of the brush
RSV_LARGE float rsv_brushed_missing(const rsv_bsdf *bsdf, rsv_vec3 w)
{
    float across = sqrtf(f_max(w.x * w.x + w.y * w.y, 1e-12f)), missing = 0;
    rsv_table_place turn = rsv_brushed_turn(
        bsdf->brush_along, bsdf->brush_across, w.x / across, w.y / across, RSV_BRUSHED_TURN);
    rsv_table_place cos = rsv_table_place_at(sqrtf(f_min(fabsf(w.z), 1)), RSV_BRUSHED_COS);
    RSV_ROLLED
    for (int k = 0; k < 4; k++) {
        rsv_table_place a = bsdf->brush_alpha, s = bsdf->brush_strength;
        float weight = (k & 1 ? a.weight : 1 - a.weight) * (k & 2 ? s.weight : 1 - s.weight);
        const rsv_brushed_rows *rows =
            &bsdf->tables->brushed_missing[a.index + (k & 1)][s.index + (k >> 1)];
        missing += weight * rsv_brushed_entry(*rows, turn, cos);
    }
    return f_max(missing, 0);
}

RSV_INLINE float rsv_brushed_missing_mean(const rsv_bsdf *bsdf)
{
    rsv_table_place a = bsdf->brush_alpha;
    float low = rsv_table_line(bsdf->tables->brushed_missing_mean[a.index], bsdf->brush_strength);
    float high =
        rsv_table_line(bsdf->tables->brushed_missing_mean[a.index + 1], bsdf->brush_strength);
    return f_max(low + a.weight * (high - low), RSV_LEAST_MISSING);
}

/// Of metal, brushed or not.
RSV_INLINE float rsv_bsdf_metal_missing(const rsv_bsdf *bsdf, rsv_vec3 n, rsv_vec3 w)
{
    if (bsdf->brushed) return rsv_brushed_missing(bsdf, rsv_to_brush(bsdf, n, w));
    return rsv_bsdf_missing(bsdf, false, 0, v3_dot(n, w));
}

RSV_INLINE float rsv_bsdf_metal_missing_mean(const rsv_bsdf *bsdf)
{
    return bsdf->brushed ? rsv_brushed_missing_mean(bsdf) : rsv_bsdf_missing_mean(bsdf, false, 0);
}

/// rsv_reflection_density of metal.
RSV_INLINE float rsv_metal_density(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, rsv_vec3 h)
{
    if (!bsdf->brushed) return rsv_reflection_density(bsdf->alpha, wi, wo, n, h);
    float x = bsdf->brush_along, y = bsdf->brush_across;
    rsv_vec3 o = rsv_to_brush(bsdf, n, wo), i = rsv_to_brush(bsdf, n, wi);
    return rsv_ggx_visible_pdf_xy(rsv_to_brush(bsdf, n, h), o, x, y) *
           rsv_ggx_visibility_xy(o, i, x, y) / (4 * f_max(v3_dot(wo, h), 1e-6f));
}

/// Reflectance of metal for light that meets it more than once (Kulla and Conty).
RSV_INLINE rsv_rgb rsv_bsdf_metal_again(const rsv_bsdf *bsdf)
{
    rsv_rgb f = bsdf->film.share > 0 ? rsv_filmed_mean(bsdf, RSV_FILMED_METAL, rsv_table_alpha(0))
                                     : rsv_fresnel_schlick_mean(bsdf->base_color);
    float missing = rsv_bsdf_metal_missing_mean(bsdf), once = 1 - missing;
    return rgb(f.r * f.r * once / (1 - f.r * missing), f.g * f.g * once / (1 - f.g * missing),
        f.b * f.b * once / (1 - f.b * missing));
}

#endif
