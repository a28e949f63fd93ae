/// How rough lobes come out through layers: s of bsdf.h, the positive solution of s = K (L / s) where K is the
/// mean over the light that a lobe sends up. Scaling a symmetric kernel so that its rows have given sums, L here, is
/// possible in just one way (Sinkhorn 1967).
#ifndef RSV_BALANCE_H
#define RSV_BALANCE_H

#include "bsdf.h"

#include <string.h>

/// Most directions that K connects.
#define RSV_BALANCE_NODES (RSV_SPREAD_COS > RSV_BRUSHED_NODES ? RSV_SPREAD_COS : RSV_BRUSHED_NODES)

/// s of channels side by side would be read in strides: one after the other instead.
typedef struct rsv_balance_channel {
    float left[RSV_BALANCE_NODES]; ///< L
    float s[RSV_BALANCE_NODES];
} rsv_balance_channel;

/// K as a sum of tables.
typedef struct rsv_balance_kernel {
    int count;             ///< of directions
    int tables;            ///< 1 to 4
    const float *table[4]; ///< [count][count]
    float weight[4];
} rsv_balance_kernel;

/// k += share of the table's entry for alpha
RSV_INLINE void rsv_add_spread(
    rsv_spread k, const rsv_spread table[RSV_TABLE_ALPHA], rsv_table_place alpha, float share)
{
    RSV_ROLLED
    for (int side = 0; side < 2; side++) {
        const rsv_spread *entry = &table[alpha.index + side];
        float weight = share * (side ? alpha.weight : 1 - alpha.weight);
        RSV_ROLLED
        for (int j = 0; j < RSV_SPREAD_COS; j++)
            RSV_ROLLED
        for (int i = 0; i < RSV_SPREAD_COS; i++)
            k[j][i] += weight * (*entry)[j][i];
    }
}

RSV_INLINE void rsv_make_lossless(rsv_spread k)
{
    float sum[RSV_SPREAD_COS] = { 0 };
    RSV_ROLLED
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        RSV_ROLLED
    for (int i = 0; i < RSV_SPREAD_COS; i++)
        sum[i] += k[j][i];
    RSV_ROLLED
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        RSV_ROLLED
    for (int i = 0; i < RSV_SPREAD_COS; i++)
        k[j][i] /= f_max(sum[i], 1e-6f);
}

/// Weight of the higher of two tabulated ior whose blend approximates the Fresnel reflectance, from normal incidence.
RSV_INLINE float rsv_share_of_high_ior(float ior)
{
    float cos_t, low = rsv_fresnel_dielectric(1, RSV_LOW_IOR, &cos_t);
    float high = rsv_fresnel_dielectric(1, RSV_HIGH_IOR, &cos_t);
    // an ior below 1.33 reflects too little for its spread to matter
    return f_min(f_max((rsv_fresnel_dielectric(1, ior, &cos_t) - low) / (high - low), -0.1f), 1);
}

RSV_INLINE float rsv_spread_cos_at(int i)
{
    float x = (float)i / (RSV_SPREAD_COS - 1);
    return x * x;
}

/// Adds to k the light that a body's surface reflects after more than one event.
RSV_INLINE void rsv_add_reflected_again(const rsv_bsdf *bsdf, rsv_spread k)
{
    float missing[RSV_SPREAD_COS], share[RSV_SPREAD_COS], sum = 0;
    RSV_ROLLED
    for (int i = 0; i < RSV_SPREAD_COS; i++) {
        missing[i] = rsv_bsdf_missing(bsdf, true, 0, rsv_spread_cos_at(i));
        share[i] = missing[i] * powf(rsv_spread_cos_at(i), 1.5f); // cos dcos in steps of sqrt(cos)
        sum += share[i];
    }
    float reflected = bsdf->transmission * (1 - rsv_bsdf_missing_transmitted(bsdf, 0));
    RSV_ROLLED
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        RSV_ROLLED
    for (int i = 0; i < RSV_SPREAD_COS; i++)
        k[j][i] += reflected * missing[i] * share[j] / f_max(sum, RSV_LEAST_MISSING);
}

RSV_INLINE void rsv_set_up_spread(const rsv_bsdf *bsdf, int kind, rsv_spread k)
{
    const rsv_bsdf_tables *t = bsdf->tables;
    memset(k, 0, sizeof(rsv_spread));
    if (kind == RSV_SPREAD_METAL) {
        rsv_add_spread(k, t->metal_spread, bsdf->alpha_place, 1);
        return;
    }
    float high = rsv_share_of_high_ior(bsdf->ior);
    rsv_add_spread(k, t->interface_spread[0], bsdf->alpha_place, 1 - high);
    rsv_add_spread(k, t->interface_spread[1], bsdf->alpha_place, high);
    if (bsdf->solid) rsv_add_reflected_again(bsdf, k);
    rsv_make_lossless(k);
}

RSV_INLINE void rsv_spread_light(
    const rsv_balance_kernel *k, const float *light, float mean[RSV_BALANCE_NODES])
{
    RSV_ROLLED
    for (int i = 0; i < k->count; i++)
        mean[i] = 0;
    RSV_ROLLED
    for (int j = 0; j < k->tables * k->count; j++) {
        const float *row = k->table[j / k->count] + j % k->count * k->count;
        float amount = k->weight[j / k->count] * light[j % k->count];
        RSV_ROLLED
        for (int i = 0; i < k->count; i++)
            mean[i] += row[i] * amount;
    }
}

/// From sqrt(K L), right for mirrors and diffuse lobes. A step of s towards K (L / s) scales an error by
/// 1 - step (1 + e), e in [0, 1] an eigenvalue of K; these steps, Chebyshev's for three, leave a 99th at most.
RSV_INLINE void rsv_find_balance(const rsv_balance_kernel *k, rsv_balance_channel *c)
{
    const float step[3] = { 0.5173f, 0.6667f, 0.9373f };
    float light[RSV_BALANCE_NODES], mean[RSV_BALANCE_NODES];
    rsv_spread_light(k, c->left, mean);
    RSV_ROLLED
    for (int i = 0; i < k->count; i++)
        c->s[i] = sqrtf(f_max(mean[i], 1e-8f));
    RSV_ROLLED
    for (int n = 0; n < 3; n++) {
        RSV_ROLLED
        for (int i = 0; i < k->count; i++)
            light[i] = c->left[i] / c->s[i];
        rsv_spread_light(k, light, mean);
        RSV_ROLLED
        for (int i = 0; i < k->count; i++)
            c->s[i] += step[n] * (mean[i] - c->s[i]);
    }
}

RSV_INLINE float rsv_balance_gap(const rsv_balance_channel *c, int i)
{
    return c->s[i] * c->s[i] - c->left[i];
}

/// @param gap out: s^2 - L in each direction
RSV_INLINE void rsv_balance_channels(
    const rsv_bsdf *bsdf, const rsv_balance_kernel *k, rsv_balance_channel c[3], rsv_rgb *gap)
{
    bool gray = rsv_bsdf_layers_are_gray(bsdf);
    RSV_ROLLED
    for (int n = 0; n < (gray ? 1 : 3); n++)
        rsv_find_balance(k, &c[n]);
    RSV_ROLLED
    for (int i = 0; i < k->count; i++)
        gap[i] =
            gray ? rgb_gray(rsv_balance_gap(c, i))
                 : rgb(rsv_balance_gap(c, i), rsv_balance_gap(c + 1, i), rsv_balance_gap(c + 2, i));
}

RSV_INLINE void rsv_set_light_left(
    const rsv_bsdf *bsdf, int node, float cos, rsv_balance_channel c[3])
{
    rsv_rgb left = rsv_bsdf_passage(bsdf, cos).light;
    c[0].left[node] = left.r;
    c[1].left[node] = left.g;
    c[2].left[node] = left.b;
}

RSV_INLINE void rsv_balance_kind(rsv_bsdf *bsdf, int kind)
{
    rsv_balance_channel c[3];
    rsv_spread k;
    rsv_set_up_spread(bsdf, kind, k);
    RSV_ROLLED
    for (int i = 0; i < RSV_SPREAD_COS; i++)
        rsv_set_light_left(bsdf, i, rsv_spread_cos_at(i), c);
    rsv_balance_kernel kernel = { RSV_SPREAD_COS, 1, { k[0] }, { 1 } };
    rsv_balance_channels(bsdf, &kernel, c, bsdf->balance[kind]);
}

RSV_INLINE void rsv_balance_brushed(rsv_bsdf *bsdf)
{
    rsv_balance_channel c[3];
    rsv_balance_kernel kernel = { .count = RSV_BRUSHED_NODES, .tables = 4 };
    rsv_table_place a = bsdf->brush_alpha, s = bsdf->brush_strength;
    RSV_ROLLED
    for (int k = 0; k < 4; k++) {
        kernel.table[k] = bsdf->tables->brushed_spread[a.index + (k & 1)][s.index + (k >> 1)][0];
        kernel.weight[k] = (k & 1 ? a.weight : 1 - a.weight) * (k & 2 ? s.weight : 1 - s.weight);
    }
    RSV_ROLLED
    for (int i = 0; i < RSV_BRUSHED_NODES; i++)
        rsv_set_light_left(bsdf, i, rsv_brushed_node_cos(i), c);
    rsv_balance_channels(bsdf, &kernel, c, bsdf->brushed_balance);
}

/// Sets `balance` and `brushed_balance` of a layered surface, after all other fields.
RSV_INLINE void rsv_bsdf_balance_layers(rsv_bsdf *bsdf)
{
    if (!bsdf->layered || bsdf->alpha == 0) return;
    bool sheet = bsdf->transmission > 0 && !bsdf->solid;
    if (bsdf->brushed) rsv_balance_brushed(bsdf);
    if ((bsdf->metallic > 0 && !bsdf->brushed) || sheet) rsv_balance_kind(bsdf, RSV_SPREAD_METAL);
    if (bsdf->metallic < 1) rsv_balance_kind(bsdf, RSV_SPREAD_INTERFACE);
}

#endif
