/// What lies over the base of rsv_bsdf: sheen, and the clear coat on top. Included by bsdf.h alone.
///
/// Sheen has the directional albedo c S(w), S(w) = (1 - cos)^k, in the one reciprocal form that knows no
/// azimuth, c S(wi) S(wo) / (pi S_mean): light off fibres that stand up, brightest along the surface. k
/// falls with roughness so that the albedo follows the one of Charlie (Estevez and Kulla 2017).
#ifndef RSV_BSDF_LAYERS_H
#define RSV_BSDF_LAYERS_H

/// Whether the layers are met from this side: from inside a body they are not.
RSV_INLINE bool rsv_bsdf_meets_layers(const rsv_bsdf *bsdf, bool front)
{
    return bsdf->layered && (front || !bsdf->solid);
}

/// c R(w) of the clear coat.
RSV_INLINE float rsv_bsdf_clearcoat_albedo(const rsv_bsdf *bsdf, float cos)
{
    float cos_t;
    cos = f_min(fabsf(cos), 1);
    if (bsdf->clearcoat == 0) return 0;
    if (bsdf->clearcoat_alpha == 0)
        return bsdf->clearcoat * rsv_fresnel_dielectric(cos, RSV_CLEARCOAT_IOR, &cos_t);
    return bsdf->clearcoat * rsv_table_dielectric(bsdf->tables->reflected,
                                 bsdf->clearcoat_eta_place, bsdf->clearcoat_place,
                                 rsv_table_cos(cos));
}

/// S(w)
RSV_INLINE float rsv_bsdf_sheen_albedo(const rsv_bsdf *bsdf, float cos)
{
    return rgb_max(bsdf->sheen) > 0 ? powf(f_max(1 - fabsf(cos), 0), bsdf->sheen_power) : 0;
}

/// What the layers leave of light: as a chance, and per channel.
typedef struct rsv_layer_passage {
    float chance;
    rsv_rgb light;
} rsv_layer_passage;

RSV_INLINE rsv_layer_passage rsv_passage(const rsv_bsdf *bsdf, float coat, float sheen)
{
    rsv_layer_passage passage = { (1 - coat) * (1 - rgb_max(bsdf->sheen) * sheen),
        rgb_scale(rsv_one_minus(rgb_scale(bsdf->sheen, sheen)), 1 - coat) };
    return passage;
}

/// Of light on one of its ways.
RSV_INLINE rsv_layer_passage rsv_bsdf_passage(const rsv_bsdf *bsdf, float cos)
{
    return rsv_passage(
        bsdf, rsv_bsdf_clearcoat_albedo(bsdf, cos), rsv_bsdf_sheen_albedo(bsdf, cos));
}

/// Of light that the base scatters in any but the diffuse lobe.
RSV_INLINE rsv_layer_passage rsv_bsdf_passage_both(const rsv_bsdf *bsdf, float cos_i, float cos_o)
{
    return rsv_passage(bsdf,
        f_max(rsv_bsdf_clearcoat_albedo(bsdf, cos_i), rsv_bsdf_clearcoat_albedo(bsdf, cos_o)),
        f_max(rsv_bsdf_sheen_albedo(bsdf, cos_i), rsv_bsdf_sheen_albedo(bsdf, cos_o)));
}

RSV_INLINE rsv_rgb rsv_bsdf_entry(const rsv_bsdf *bsdf, float cos)
{
    if (!bsdf->coated) return rgb_gray(1);
    rsv_rgb passed = rgb_scale(bsdf->specular_tint, rsv_bsdf_interface_albedo(bsdf, cos));
    passed = rsv_one_minus(passed);
    return bsdf->layered ? rgb_mul(passed, rsv_bsdf_passage(bsdf, cos).light) : passed;
}

/// Chance that light reaches the diffuse base; its share per channel is rsv_bsdf_entry.
RSV_INLINE float rsv_bsdf_entry_chance(const rsv_bsdf *bsdf, float cos)
{
    if (!bsdf->coated) return 1;
    float chance = 1 - rgb_max(bsdf->specular_tint) * rsv_bsdf_interface_albedo(bsdf, cos);
    return bsdf->layered ? chance * rsv_bsdf_passage(bsdf, cos).chance : chance;
}

/// Weight of light that reached the diffuse base.
RSV_INLINE rsv_rgb rsv_bsdf_entry_weight(const rsv_bsdf *bsdf, float cos)
{
    float chance = rsv_bsdf_entry_chance(bsdf, cos);
    return chance > 0 ? rgb_scale(rsv_bsdf_entry(bsdf, cos), 1 / chance) : rgb_gray(0);
}

/// Density of directions off the clear coat, without its share.
RSV_INLINE float rsv_clearcoat_density(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_t;
    rsv_vec3 h = v3_normalize(v3_add(wi, wo));
    return rsv_fresnel_dielectric(f_min(v3_dot(wo, h), 1), RSV_CLEARCOAT_IOR, &cos_t) *
           rsv_reflection_density(bsdf->clearcoat_alpha, wi, wo, n, h);
}

/// Density of directions off the fibres: S(wi) cos / (pi S_mean).
RSV_INLINE float rsv_sheen_density(const rsv_bsdf *bsdf, float cos_i)
{
    float k = bsdf->sheen_power, mean = 2 / ((k + 1) * (k + 2));
    return rsv_bsdf_sheen_albedo(bsdf, cos_i) * cos_i / (RSV_PI * mean);
}

/// The layers' own lobes, and the base's dimmed by them. @param base in, directed lobes; out, all
RSV_INLINE void rsv_add_layers(
    rsv_bsdf_value *base, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_o = v3_dot(n, wo), cos_i = v3_dot(n, wi);
    rsv_layer_passage passage = rsv_bsdf_passage_both(bsdf, cos_i, cos_o);
    base->response = rgb_mul(base->response, passage.light);
    base->pdf_solid_angle *= passage.chance;
    if (cos_i <= 0) return;
    if (bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0)
        rsv_add_term(base, bsdf->clearcoat * rsv_clearcoat_density(bsdf, wi, wo, n), rgb_gray(1));
    float largest = rgb_max(bsdf->sheen);
    if (largest == 0) return;
    // fibres lie under the coat
    float coat =
        f_max(rsv_bsdf_clearcoat_albedo(bsdf, cos_i), rsv_bsdf_clearcoat_albedo(bsdf, cos_o));
    float share = (1 - coat) * largest * rsv_bsdf_sheen_albedo(bsdf, cos_o);
    rsv_add_term(base, share * rsv_sheen_density(bsdf, cos_i), rgb_scale(bsdf->sheen, 1 / largest));
}

#endif
