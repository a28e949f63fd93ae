/// Directional albedos of the GGX interface, which have no closed form: tabulated by tables_generate.c
/// when the library is built, looked up linearly. Plain C, also for device code.
#ifndef RSV_BSDF_TABLES_H
#define RSV_BSDF_TABLES_H

#include "../core/vec.h"

#define RSV_TABLE_COS 64   ///< cos = (k / 63)^2
#define RSV_TABLE_ALPHA 40 ///< alpha = (k / 39)^2
#define RSV_TABLE_ETA 20   ///< from 1 to RSV_MOST_IOR: rsv_table_bend

#define RSV_MOST_IOR 1000.0f ///< reflects all but 0.4 %
#define RSV_MOST_BEND ((RSV_MOST_IOR - 1) / (RSV_MOST_IOR + 1))
#define RSV_LOW_BENDS 13 ///< entries up to eta = 3, those that occur

#define RSV_FILM_STEPS 2048          ///< of a path through a thin film
#define RSV_FILM_STEPS_PER_UM 200.0f ///< beyond the last one, 10 um, fringes have no colour left
#define RSV_FILM_MOST_PATH ((RSV_FILM_STEPS - 1) / RSV_FILM_STEPS_PER_UM)
#define RSV_FACET_COS 32 ///< cos = k / 31, with a facet

#define RSV_BRUSHED_ALPHA 16    ///< alpha across = (k / 15)^2
#define RSV_BRUSHED_STRENGTH 11 ///< alpha along = across + (1 - across) (k / 10)^2
#define RSV_BRUSHED_TURN 8      ///< alpha seen = across + (along - across) (k / 7)^2
#define RSV_BRUSHED_COS 24      ///< cos = (k / 23)^2

/// Directions between which its light is shared out, placed likewise.
#define RSV_BRUSHED_NODE_TURNS 5
#define RSV_BRUSHED_NODE_COS 10
#define RSV_BRUSHED_NODES (RSV_BRUSHED_NODE_TURNS * RSV_BRUSHED_NODE_COS)

#define RSV_LOW_IOR 1.5f
#define RSV_HIGH_IOR 3.0f
#define RSV_SPREAD_COS 24 ///< cos = (k / 23)^2

typedef float rsv_albedo_row[RSV_TABLE_COS];
typedef float rsv_brushed_rows[RSV_BRUSHED_TURN][RSV_BRUSHED_COS];

/// Light off white metal with multiple scattering, or reflected once by a dielectric.
enum { RSV_SPREAD_METAL, RSV_SPREAD_INTERFACE, RSV_SPREADS };

/// Where a rough surface sends light: [j][k] is the fraction of the light arriving at cosine k that leaves near cosine
/// j, so that sum_j [j][k] f(cos_j) is its integral of f, linear in sqrt(cos) between entries.
typedef float rsv_spread[RSV_SPREAD_COS][RSV_SPREAD_COS];
/// The same of brushed metal, which scatters by azimuth too: between nodes turn * RSV_BRUSHED_NODE_COS + cos.
typedef float rsv_brushed_spread[RSV_BRUSHED_NODES][RSV_BRUSHED_NODES];

/// Means are hemispherical, 2 int f cos dcos, of the interpolated tables.
typedef struct rsv_bsdf_tables {
    /// Energy that single scattering by a white conductor loses: 1 - E.
    rsv_albedo_row conductor_missing[RSV_TABLE_ALPHA];
    float conductor_missing_mean[RSV_TABLE_ALPHA];
    /// Reflected once by a dielectric, from outside.
    rsv_albedo_row reflected[RSV_TABLE_ETA][RSV_TABLE_ALPHA];
    float reflected_mean[RSV_TABLE_ETA][RSV_TABLE_ALPHA];
    /// Neither reflected nor transmitted once by a dielectric, from [0] outside, [1] inside.
    rsv_albedo_row missing[2][RSV_TABLE_ETA][RSV_TABLE_ALPHA];
    float missing_mean[2][RSV_TABLE_ETA][RSV_TABLE_ALPHA];
    rsv_spread metal_spread[RSV_TABLE_ALPHA];        ///< lossless
    rsv_spread interface_spread[2][RSV_TABLE_ALPHA]; ///< of ior RSV_LOW_IOR, RSV_HIGH_IOR
    /// Reflected once by facets whose reflectance is 1 at cosine k, 0 at k - 1 and k + 1, and linear in between.
    rsv_albedo_row facet[RSV_FACET_COS][RSV_TABLE_ALPHA];
    float facet_mean[RSV_FACET_COS][RSV_TABLE_ALPHA];
    float film_cosine[RSV_FILM_STEPS][3]; ///< thin_film.h
    /// conductor_missing of surfaces with two widths.
    rsv_brushed_rows brushed_missing[RSV_BRUSHED_ALPHA][RSV_BRUSHED_STRENGTH];
    float brushed_missing_mean[RSV_BRUSHED_ALPHA][RSV_BRUSHED_STRENGTH];
    rsv_brushed_spread brushed_spread[RSV_BRUSHED_ALPHA][RSV_BRUSHED_STRENGTH]; ///< lossless
} rsv_bsdf_tables;

extern const rsv_bsdf_tables rsv_bsdf_tables_data;

/// Where a value lies between two entries of an axis.
typedef struct rsv_table_place {
    int index;
    float weight; ///< of entry index + 1
} rsv_table_place;

RSV_INLINE rsv_table_place rsv_table_place_at(float x, int count)
{
    float scaled = f_min(f_max(x, 0), 1) * (float)(count - 1);
    int index = (int)scaled < count - 2 ? (int)scaled : count - 2;
    rsv_table_place place = { index, scaled - (float)index };
    return place;
}
RSV_INLINE rsv_table_place rsv_table_alpha(float alpha)
{
    return rsv_table_place_at(sqrtf(alpha), RSV_TABLE_ALPHA);
}
RSV_INLINE rsv_table_place rsv_table_cos(float cos)
{
    return rsv_table_place_at(sqrtf(f_max(cos, 0)), RSV_TABLE_COS);
}
/// (eta - 1) / (eta + 1) of entry k.
RSV_INLINE float rsv_table_bend(int k)
{
    const float high = RSV_TABLE_ETA - 1 - RSV_LOW_BENDS;
    float low = (float)k / RSV_LOW_BENDS;
    if (k <= RSV_LOW_BENDS) return 0.5f * low * low;
    return 0.5f + (RSV_MOST_BEND - 0.5f) * (float)(k - RSV_LOW_BENDS) / high;
}
RSV_INLINE rsv_table_place rsv_table_eta(float eta)
{
    const float high = RSV_TABLE_ETA - 1 - RSV_LOW_BENDS;
    float bend = (eta - 1) / (eta + 1);
    float at = bend <= 0.5f ? RSV_LOW_BENDS * sqrtf(2 * bend)
                            : RSV_LOW_BENDS + high * (bend - 0.5f) / (RSV_MOST_BEND - 0.5f);
    return rsv_table_place_at(at / (RSV_TABLE_ETA - 1), RSV_TABLE_ETA);
}

/// Of facets.
RSV_INLINE rsv_table_place rsv_facet_cos(float cos)
{
    return rsv_table_place_at(cos, RSV_FACET_COS);
}

RSV_INLINE float rsv_table_line(const float *entry, rsv_table_place at)
{
    return entry[at.index] + at.weight * (entry[at.index + 1] - entry[at.index]);
}
/// @param row [RSV_TABLE_ALPHA]
RSV_INLINE float rsv_table_albedo(
    const rsv_albedo_row *row, rsv_table_place alpha, rsv_table_place cos)
{
    float low = rsv_table_line(row[alpha.index], cos);
    return low + alpha.weight * (rsv_table_line(row[alpha.index + 1], cos) - low);
}
RSV_INLINE float rsv_table_mean(
    const float (*mean)[RSV_TABLE_ALPHA], rsv_table_place eta, rsv_table_place alpha)
{
    float low = rsv_table_line(mean[eta.index], alpha);
    return low + eta.weight * (rsv_table_line(mean[eta.index + 1], alpha) - low);
}
RSV_INLINE float rsv_table_dielectric(const rsv_albedo_row (*table)[RSV_TABLE_ALPHA],
    rsv_table_place eta, rsv_table_place alpha, rsv_table_place cos)
{
    float low = rsv_table_albedo(table[eta.index], alpha, cos);
    return low + eta.weight * (rsv_table_albedo(table[eta.index + 1], alpha, cos) - low);
}

// ---- brushed metal ------------------------------------------------------------------------------

/// Width along the brush. @param across width across it
RSV_INLINE float rsv_brushed_along(float across, float strength)
{
    return across + (1 - across) * strength * strength;
}

/// Of the azimuth of a direction, by the width that it sees. @param x, y widths, x >= y @param cos, sin of the azimuth
/// @param count of entries
RSV_INLINE rsv_table_place rsv_brushed_turn(float x, float y, float cos, float sin, int count)
{
    float seen = sqrtf(x * x * cos * cos + y * y * sin * sin), share = 0;
    if (x > y) share = f_max(seen - y, 0) / (x - y);
    return rsv_table_place_at(sqrtf(share), count);
}

/// Four nodes about a direction, and their weights.
typedef struct rsv_brushed_place {
    int node[4];
    float weight[4];
} rsv_brushed_place;

/// @param w in the frame of the brush
RSV_INLINE rsv_brushed_place rsv_brushed_place_of(float x, float y, rsv_vec3 w)
{
    float across = sqrtf(f_max(w.x * w.x + w.y * w.y, 1e-12f));
    rsv_table_place turn =
        rsv_brushed_turn(x, y, w.x / across, w.y / across, RSV_BRUSHED_NODE_TURNS);
    rsv_table_place cos = rsv_table_place_at(sqrtf(f_min(fabsf(w.z), 1)), RSV_BRUSHED_NODE_COS);
    rsv_brushed_place at;
    RSV_ROLLED
    for (int k = 0; k < 4; k++) {
        at.node[k] = (turn.index + (k >> 1)) * RSV_BRUSHED_NODE_COS + cos.index + (k & 1);
        at.weight[k] =
            (k >> 1 ? turn.weight : 1 - turn.weight) * (k & 1 ? cos.weight : 1 - cos.weight);
    }
    return at;
}

RSV_INLINE float rsv_brushed_node_cos(int node)
{
    float x = (float)(node % RSV_BRUSHED_NODE_COS) / (RSV_BRUSHED_NODE_COS - 1);
    return x * x;
}

#endif
