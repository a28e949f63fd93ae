/// Layers over the base of rsv_bsdf: sheen, and the clear coat on top. Included only by bsdf.h.
///
/// Sheen has the directional albedo c S(w), S(w) = (1 - cos)^k, in the only reciprocal form without azimuth, c S(wi)
/// S(wo) / (pi S_mean). It models upright fibres, which are brightest at grazing angles. k falls with roughness so that
/// the albedo is close to that of Charlie (Estevez and Kulla 2017). Under a clear coat, S is multiplied by its 1 - c R.
#ifndef RSV_BSDF_LAYERS_H
#define RSV_BSDF_LAYERS_H

#define RSV_LAYER_VALUES 9

/// The values of a layer.
typedef struct rsv_layer_values {
    float value[RSV_LAYER_VALUES];
} rsv_layer_values;

RSV_INLINE rsv_layer_values rsv_bsdf_layer_values(const rsv_bsdf *b)
{
    rsv_layer_values v = { { b->clearcoat, b->clearcoat_alpha, b->sheen_power, b->sheen.r,
        b->sheen.g, b->sheen.b, b->film.share, b->film.ior, b->film.thickness } };
    return v;
}

/// Whether a layer scatters into a solid angle.
RSV_INLINE bool rsv_bsdf_has_rough_layers(const rsv_bsdf *bsdf)
{
    return !rgb_is_black(bsdf->sheen) || (bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0);
}

/// Whether the layers treat all channels equally.
RSV_INLINE bool rsv_bsdf_layers_are_gray(const rsv_bsdf *bsdf)
{
    return bsdf->sheen.r == bsdf->sheen.g && bsdf->sheen.g == bsdf->sheen.b;
}

/// Whether the layers are met from this side: from inside a body they are not.
RSV_INLINE bool rsv_bsdf_meets_layers(const rsv_bsdf *bsdf, bool front)
{
    return bsdf->layered && (front || !bsdf->solid);
}

/// c R(w) of the clear coat.
RSV_LARGE float rsv_bsdf_clearcoat_albedo(const rsv_bsdf *bsdf, float cos)
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

/// The normal by which the clear coat reflects, on the side of n; n where light would end below the surface.
RSV_INLINE rsv_vec3 rsv_bsdf_coat_normal(const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n)
{
    if (!bsdf->tilted) return n;
    rsv_vec3 own = bsdf->coat_normal;
    if (v3_dot(own, n) < 0) own = v3_neg(own);
    float cos = v3_dot(own, wo);
    bool lost = cos <= 0 || 2 * cos * v3_dot(own, n) <= v3_dot(wo, n);
    return lost ? n : own;
}

/// (1 - c R(m.wo)) / (1 - c R(n.wo))
RSV_INLINE float rsv_bsdf_tilted_passage(const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n)
{
    if (!bsdf->tilted) return 1;
    float own = v3_dot(rsv_bsdf_coat_normal(bsdf, wo, n), wo), cos = v3_dot(n, wo);
    return (1 - rsv_bsdf_clearcoat_albedo(bsdf, own)) /
           f_max(1 - rsv_bsdf_clearcoat_albedo(bsdf, cos), 1e-6f);
}

/// S(w)
RSV_INLINE float rsv_bsdf_sheen_albedo(const rsv_bsdf *bsdf, float cos)
{
    return rgb_max(bsdf->sheen) > 0 ? powf(f_max(1 - fabsf(cos), 0), bsdf->sheen_power) : 0;
}

/// Light that the layers transmit: as a probability, and per channel.
typedef struct rsv_layer_passage {
    float chance;
    rsv_rgb light;
} rsv_layer_passage;

/// L(w)
RSV_INLINE rsv_layer_passage rsv_bsdf_passage(const rsv_bsdf *bsdf, float cos)
{
    float coat = 1 - rsv_bsdf_clearcoat_albedo(bsdf, cos), sheen = rsv_bsdf_sheen_albedo(bsdf, cos);
    rsv_layer_passage passage = { coat * (1 - rgb_max(bsdf->sheen) * sheen),
        rgb_scale(rsv_one_minus(rgb_scale(bsdf->sheen, sheen)), coat) };
    return passage;
}

/// L / s; s^2 can come out too small only by interpolation where L is next to nothing.
RSV_INLINE float rsv_balanced(float left, float gap)
{
    return left > 0 ? left / sqrtf(f_max(left + gap, 0.25f * left)) : 0;
}

/// a(w) for light that spreads like RSV_SPREAD_*.
RSV_INLINE rsv_rgb rsv_bsdf_way(const rsv_bsdf *bsdf, int spread, float cos)
{
    rsv_rgb left = rsv_bsdf_passage(bsdf, cos).light;
    rsv_table_place at = rsv_table_place_at(sqrtf(fabsf(cos)), RSV_SPREAD_COS);
    const rsv_rgb *gap = &bsdf->balance[spread][at.index];
    rsv_rgb here = rgb_mad(gap[0], at.weight, rgb_sub(gap[1], gap[0]));
    return rgb(
        rsv_balanced(left.r, here.r), rsv_balanced(left.g, here.g), rsv_balanced(left.b, here.b));
}

/// a(wi) a(wo)
RSV_INLINE rsv_rgb rsv_bsdf_both_ways(const rsv_bsdf *bsdf, int spread, float cos_i, float cos_o)
{
    return rgb_mul(rsv_bsdf_way(bsdf, spread, cos_i), rsv_bsdf_way(bsdf, spread, cos_o));
}

/// a(w) for light off brushed metal. @param w in the frame of the brush
RSV_INLINE rsv_rgb rsv_bsdf_brushed_way(const rsv_bsdf *bsdf, rsv_vec3 w)
{
    rsv_rgb left = rsv_bsdf_passage(bsdf, w.z).light, gap = rgb_gray(0);
    rsv_brushed_place at = rsv_brushed_place_of(bsdf->brush_along, bsdf->brush_across, w);
    RSV_ROLLED
    for (int k = 0; k < 4; k++)
        gap = rgb_mad(gap, at.weight[k], bsdf->brushed_balance[at.node[k]]);
    return rgb(
        rsv_balanced(left.r, gap.r), rsv_balanced(left.g, gap.g), rsv_balanced(left.b, gap.b));
}

/// a(wi) a(wo) of brushed metal
RSV_INLINE rsv_rgb rsv_bsdf_brushed_ways(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    return rgb_mul(rsv_bsdf_brushed_way(bsdf, rsv_to_brush(bsdf, n, wi)),
        rsv_bsdf_brushed_way(bsdf, rsv_to_brush(bsdf, n, wo)));
}

RSV_LARGE rsv_rgb rsv_bsdf_exit(const rsv_bsdf *bsdf, float cos)
{
    if (!bsdf->coated) return rgb_gray(1);
    rsv_rgb passed = rsv_one_minus(rsv_bsdf_coat_albedo(bsdf, cos));
    return bsdf->layered ? rgb_mul(passed, rsv_bsdf_passage(bsdf, cos).light) : passed;
}

RSV_INLINE rsv_rgb rsv_bsdf_entry(const rsv_bsdf *bsdf, float cos)
{
    return bsdf->coated ? rgb_mul(rsv_bsdf_exit(bsdf, cos), bsdf->entry_scale) : rgb_gray(1);
}

/// Chance that light comes from the diffuse base; its share per channel is rsv_bsdf_exit.
RSV_INLINE float rsv_bsdf_exit_chance(const rsv_bsdf *bsdf, float cos)
{
    if (!bsdf->coated) return 1;
    float chance = 1 - rsv_bsdf_coat_chance(bsdf, cos);
    return bsdf->layered ? chance * rsv_bsdf_passage(bsdf, cos).chance : chance;
}

/// Weight of light that comes from the diffuse base.
RSV_INLINE rsv_rgb rsv_bsdf_exit_weight(const rsv_bsdf *bsdf, float cos)
{
    float chance = rsv_bsdf_exit_chance(bsdf, cos);
    return chance > 0 ? rgb_scale(rsv_bsdf_exit(bsdf, cos), 1 / chance) : rgb_gray(0);
}

/// Density of directions off the clear coat, without its share.
RSV_INLINE float rsv_clearcoat_density(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    float cos_t;
    rsv_vec3 h = v3_normalize(v3_add(wi, wo));
    return rsv_fresnel_dielectric(f_min(v3_dot(wo, h), 1), RSV_CLEARCOAT_IOR, &cos_t) *
           rsv_reflection_density(bsdf->clearcoat_alpha, wi, wo, n, h);
}

/// S(w) as the coat leaves it.
RSV_INLINE float rsv_bsdf_coated_sheen(const rsv_bsdf *bsdf, float cos)
{
    return rsv_bsdf_sheen_albedo(bsdf, cos) * (1 - rsv_bsdf_clearcoat_albedo(bsdf, cos));
}

/// Light that the wide layers (those without azimuth) reflect towards `wo` under uniform illumination.
typedef struct rsv_wide_layers {
    rsv_rgb sheen;
} rsv_wide_layers;

RSV_INLINE rsv_wide_layers rsv_bsdf_wide_layers(const rsv_bsdf *bsdf, float cos_o)
{
    rsv_wide_layers wide = { rgb_scale(bsdf->sheen, rsv_bsdf_coated_sheen(bsdf, cos_o)) };
    return wide;
}

RSV_INLINE rsv_rgb rsv_wide_layers_albedo(const rsv_wide_layers *wide) { return wide->sheen; }

/// sum + the light that they reflect from cos_i, times pi / cos_i
RSV_INLINE rsv_rgb rsv_add_wide_layers(
    rsv_rgb sum, const rsv_bsdf *bsdf, const rsv_wide_layers *wide, float cos_i)
{
    if (rgb_is_black(wide->sheen)) return sum;
    return rgb_mad(sum, rsv_bsdf_coated_sheen(bsdf, cos_i) / bsdf->sheen_mean, wide->sheen);
}

/// About the largest albedo of a wide layer.
RSV_INLINE rsv_rgb rsv_bsdf_wide_layers_most(const rsv_bsdf *bsdf) { return bsdf->sheen; }

RSV_INLINE void rsv_add_clearcoat(
    rsv_bsdf_value *value, const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n)
{
    rsv_vec3 own = rsv_bsdf_coat_normal(bsdf, wo, n);
    if (v3_dot(n, wi) <= 0 || v3_dot(own, wi) <= 0) return;
    if (bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0)
        rsv_add_term(
            value, bsdf->clearcoat * rsv_clearcoat_density(bsdf, wi, wo, own), rgb_gray(1));
}

RSV_INLINE void rsv_add_sheen(rsv_bsdf_value *value, const rsv_bsdf *bsdf, float cos_i, float cos_o)
{
    float largest = rgb_max(bsdf->sheen);
    if (cos_i <= 0 || largest == 0) return;
    float density = rsv_bsdf_coated_sheen(bsdf, cos_i) * cos_i / (RSV_PI * bsdf->sheen_mean);
    rsv_add_term(value, largest * rsv_bsdf_coated_sheen(bsdf, cos_o) * density,
        rgb_scale(bsdf->sheen, 1 / largest));
}

// ---- layers of a material ---------------------------------------------------------------------

RSV_INLINE float rsv_microsurface_width(float roughness)
{
    float alpha = roughness * roughness;
    return alpha < RSV_SMOOTH_ALPHA ? 0 : alpha;
}

/// Number of samples of f in the mean over the hemisphere, 2 int f cos dcos.
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

RSV_INLINE void rsv_bsdf_set_layers(rsv_bsdf *bsdf, const rsv_material *m)
{
    bsdf->clearcoat = m->clearcoat;
    bsdf->clearcoat_alpha = rsv_microsurface_width(m->clearcoat_roughness);
    bsdf->tilted = rsv_coat_has_own_normals(m);
    // one surface has one ideal reflection, along n: the coat's lobe is narrow instead
    if (bsdf->tilted) bsdf->clearcoat_alpha = f_max(bsdf->clearcoat_alpha, RSV_SMOOTH_ALPHA);
    bsdf->clearcoat_place = rsv_table_alpha(bsdf->clearcoat_alpha);
    bsdf->sheen = m->sheen_color;
    bsdf->sheen_power = 2 / f_max(m->sheen_roughness, 0.1f);
    bsdf->layered = m->clearcoat > 0 || !rgb_is_black(m->sheen_color);
    if (!rgb_is_black(m->sheen_color)) bsdf->sheen_mean = rsv_bsdf_sheen_mean(bsdf);
}

#endif
