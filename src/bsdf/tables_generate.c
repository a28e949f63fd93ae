/// Build tool: integrates the tables declared in tables.h and writes them as C. `tables_generate OUTPUT.c`
///
/// The albedo of single scattering is the mean of F G2 / G1 over visible normals. Midpoints of a grid on their unit
/// square integrate it to a few 1e-4.
#include "fresnel.h"
#include "ggx.h"
#include "tables.h"

#include <stdio.h>

#define COLUMNS 32 ///< around the normal
#define ROWS 96    ///< away from it, denser towards the long tail of GGX

/// Single scattering seen from one direction: by white metal, and by dielectrics from both sides.
typedef struct albedos {
    double metal;
    double reflected[2][RSV_TABLE_ETA], transmitted[2][RSV_TABLE_ETA];
    double facet[RSV_FACET_COS]; ///< by cosine with the facet
} albedos;

static float square(int k, int count)
{
    float x = (float)k / (float)(count - 1);
    return x * x;
}

/// Far side's ior over that of the side seen.
static float eta_of(int side, int e)
{
    float x = rsv_table_bend(e), eta = (1 + x) / (1 - x);
    return side ? 1 / eta : eta;
}

static void add_to_facets(albedos *sum, float cos, double amount)
{
    rsv_table_place at = rsv_facet_cos(cos);
    sum->facet[at.index] += amount * (1 - (double)at.weight);
    sum->facet[at.index + 1] += amount * (double)at.weight;
}

/// A facet that is seen from one direction.
typedef struct facet {
    rsv_vec3 wo, h;
    float alpha;
    double weight;
    double seen; ///< share of its mirrored light that is not masked
} facet;

static void add_facet(albedos *sum, const facet *f, int side, int e)
{
    float eta = eta_of(side, e), cos_t, cos_h = f_max(v3_dot(f->wo, f->h), 0);
    double fresnel = (double)rsv_fresnel_dielectric(cos_h, eta, &cos_t);
    float down = f->wo.z / eta - (cos_h / eta - cos_t) * f->h.z;
    sum->reflected[side][e] += f->weight * f->seen * fresnel;
    if (down > 0)
        sum->transmitted[side][e] +=
            f->weight * (1 - fresnel) * (double)rsv_ggx_visibility(f->wo.z, down, f->alpha);
}

static albedos integrate(float cos_o, float alpha)
{
    albedos sum = { 0 };
    rsv_vec3 wo = v3(sqrtf(1 - cos_o * cos_o), 0, cos_o);
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        float u = ((float)(i % COLUMNS) + 0.5f) / COLUMNS, v = ((float)(i / COLUMNS) + 0.5f) / ROWS;
        facet f = { .wo = wo, .alpha = alpha, .weight = 3 * (double)(v * v) / (COLUMNS * ROWS) };
        f.h = rsv_ggx_sample_visible(wo, alpha, 0.5f * u, 1 - v * v * v);
        float up = 2 * v3_dot(wo, f.h) * f.h.z - wo.z;
        f.seen = up > 0 ? (double)rsv_ggx_visibility(wo.z, up, alpha) : 0;
        sum.metal += f.weight * f.seen;
        add_to_facets(&sum, v3_dot(wo, f.h), f.weight * f.seen);
        for (int side = 0; side < 2; side++)
            for (int e = 0; e < RSV_TABLE_ETA; e++)
                add_facet(&sum, &f, side, e);
    }
    return sum;
}

static albedos smooth(float cos_o)
{
    albedos sum = { .metal = 1 };
    add_to_facets(&sum, cos_o, 1);
    for (int side = 0; side < 2; side++) {
        for (int e = 0; e < RSV_TABLE_ETA; e++) {
            float cos_t, fresnel = rsv_fresnel_dielectric(cos_o, eta_of(side, e), &cos_t);
            sum.reflected[side][e] = (double)fresnel;
            sum.transmitted[side][e] = 1 - (double)fresnel;
        }
    }
    return sum;
}

static void fill(rsv_bsdf_tables *t, int a, int c)
{
    float cos_o = f_max(square(c, RSV_TABLE_COS), 1e-5f);
    albedos seen = a ? integrate(cos_o, square(a, RSV_TABLE_ALPHA)) : smooth(cos_o);
    t->conductor_missing[a][c] = (float)(1 - seen.metal);
    for (int k = 0; k < RSV_FACET_COS; k++)
        t->facet[k][a][c] = (float)seen.facet[k];
    for (int e = 0; e < RSV_TABLE_ETA; e++) {
        t->reflected[e][a][c] = (float)seen.reflected[0][e];
        for (int side = 0; side < 2; side++)
            t->missing[side][e][a][c] =
                (float)(1 - seen.reflected[side][e] - seen.transmitted[side][e]);
    }
}

/// 2 int f cos dcos of the interpolant: linear in x = sqrt(cos), so 4 int f x^3 dx.
static float mean(const float *row)
{
    enum { STEPS = 16 };
    double sum = 0;
    for (int k = 0; k + 1 < RSV_TABLE_COS; k++) {
        for (int i = 0; i < STEPS; i++) {
            double w = (i + 0.5) / STEPS, x = (k + w) / (RSV_TABLE_COS - 1);
            sum += 4 * x * x * x * ((1 - w) * (double)row[k] + w * (double)row[k + 1]);
        }
    }
    return (float)(sum / (STEPS * (RSV_TABLE_COS - 1)));
}

/// Shares a unit of light between the two entries about its cosine.
static void spread_at(double row[RSV_SPREAD_COS], double x, double amount)
{
    double place = x * (RSV_SPREAD_COS - 1);
    int j = place < RSV_SPREAD_COS - 2 ? (int)place : RSV_SPREAD_COS - 2;
    row[j] += amount * (j + 1 - place);
    row[j + 1] += amount * (place - j);
}

/// Single scattering, as in `integrate`. @param ior of a dielectric; 0 = metal @return its sum
static double spread_once(double row[RSV_SPREAD_COS], float ior, float cos_o, float alpha)
{
    double sum = 0;
    rsv_vec3 wo = v3(sqrtf(1 - cos_o * cos_o), 0, cos_o);
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        float u = ((float)(i % COLUMNS) + 0.5f) / COLUMNS, v = ((float)(i / COLUMNS) + 0.5f) / ROWS;
        rsv_vec3 h = rsv_ggx_sample_visible(wo, alpha, 0.5f * u, 1 - v * v * v);
        float cos_t, cos_h = f_max(v3_dot(wo, h), 0), up = 2 * cos_h * h.z - wo.z;
        if (up <= 0) continue;
        float amount = 3 * v * v / (COLUMNS * ROWS) * rsv_ggx_visibility(wo.z, up, alpha);
        if (ior > 0) amount *= rsv_fresnel_dielectric(cos_h, ior, &cos_t);
        spread_at(row, sqrt((double)up), (double)amount);
        sum += (double)amount;
    }
    return sum;
}

/// Adds multiple scattering, of density missing(cos) cos.
static void spread_again(double row[RSV_SPREAD_COS], const float *missing, double amount)
{
    enum { STEPS = 1024 };
    double all[RSV_SPREAD_COS] = { 0 }, sum = 0;
    for (int k = 0; k < STEPS; k++) {
        double x = (k + 0.5) / STEPS;
        spread_at(all, x,
            x * x * x *
                (double)rsv_table_line(missing, rsv_table_place_at((float)x, RSV_TABLE_COS)));
    }
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        sum += all[j];
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        row[j] += amount * all[j] / sum;
}

/// @param ior of a dielectric; 0 = metal
static void fill_spread(rsv_spread spread, const float *missing, float ior, int a, int k)
{
    double row[RSV_SPREAD_COS] = { 0 };
    float cos_t, cos_o = f_max(square(k, RSV_SPREAD_COS), 1e-5f);
    if (a == 0) {
        row[k] = ior > 0 ? (double)rsv_fresnel_dielectric(cos_o, ior, &cos_t) : 1;
    } else {
        double once = spread_once(row, ior, cos_o, square(a, RSV_TABLE_ALPHA));
        if (ior == 0) spread_again(row, missing, 1 - once);
    }
    for (int j = 0; j < RSV_SPREAD_COS; j++)
        spread[j][k] = (float)row[j];
}

static void fill_spreads(rsv_bsdf_tables *t, int a)
{
    for (int k = 0; k < RSV_SPREAD_COS; k++) {
        fill_spread(t->metal_spread[a], t->conductor_missing[a], 0, a, k);
        fill_spread(t->interface_spread[0][a], NULL, RSV_LOW_IOR, a, k);
        fill_spread(t->interface_spread[1][a], NULL, RSV_HIGH_IOR, a, k);
    }
}

static void fill_means(rsv_bsdf_tables *t, int a)
{
    t->conductor_missing_mean[a] = mean(t->conductor_missing[a]);
    for (int e = 0; e < RSV_TABLE_ETA; e++) {
        t->reflected_mean[e][a] = mean(t->reflected[e][a]);
        t->missing_mean[0][e][a] = mean(t->missing[0][e][a]);
        t->missing_mean[1][e][a] = mean(t->missing[1][e][a]);
    }
    for (int k = 0; k < RSV_FACET_COS; k++)
        t->facet_mean[k][a] = mean(t->facet[k][a]);
}

/// Single scattering by white metal with two widths. @param phi azimuth of the direction seen, from the longer
static double brushed_albedo(float x, float y, float cos_o, float phi)
{
    enum { AROUND = 64, AWAY = 64 };
    float sin_o = sqrtf(1 - cos_o * cos_o);
    rsv_vec3 wo = v3(sin_o * cosf(phi), sin_o * sinf(phi), cos_o);
    double sum = 0;
    for (int i = 0; i < AROUND * AWAY; i++) {
        float u = ((float)(i % AROUND) + 0.5f) / AROUND, v = ((float)(i / AROUND) + 0.5f) / AWAY;
        rsv_vec3 h = rsv_ggx_sample_visible_xy(wo, x, y, u, 1 - v * v * v);
        rsv_vec3 wi = v3_sub(v3_scale(h, 2 * v3_dot(wo, h)), wo);
        if (wi.z > 0) sum += 3 * (double)(v * v * rsv_ggx_visibility_xy(wo, wi, x, y));
    }
    return sum / (AROUND * AWAY);
}

/// 2 int f cos dcos over a quarter of all azimuths, of interpolated values.
static float brushed_mean(const rsv_brushed_rows rows, float x, float y)
{
    enum { TURNS = 64, STEPS = 128 };
    double sum = 0, weight = 0;
    for (int i = 0; i < TURNS * STEPS; i++) {
        double phi = (i % TURNS + 0.5) / TURNS * 0.5 * (double)RSV_PI;
        double root = (i / TURNS + 0.5) / STEPS, cubed = root * root * root;
        rsv_table_place turn =
            rsv_brushed_turn(x, y, (float)cos(phi), (float)sin(phi), RSV_BRUSHED_TURN);
        rsv_table_place at = rsv_table_place_at((float)root, RSV_BRUSHED_COS);
        double low = (double)rsv_table_line(rows[turn.index], at);
        double high = (double)rsv_table_line(rows[turn.index + 1], at);
        sum += cubed * (low + (double)turn.weight * (high - low));
        weight += cubed;
    }
    return (float)(sum / weight);
}

/// Azimuth of directions that see a width of y + (x - y) share.
static float brushed_azimuth(float x, float y, float share)
{
    float seen = y + (x - y) * share;
    float cos2 = x > y ? (seen * seen - y * y) / (x * x - y * y) : 0;
    return acosf(sqrtf(f_min(f_max(cos2, 0), 1)));
}

/// Light that scatters from one node to others, not normalised.
typedef struct brushed_light {
    double at[RSV_BRUSHED_NODES], sum;
} brushed_light;

static void add_brushed_light(brushed_light *light, float x, float y, rsv_vec3 wi, double amount)
{
    rsv_brushed_place at = rsv_brushed_place_of(x, y, wi);
    for (int k = 0; k < 4; k++)
        light->at[at.node[k]] += amount * (double)at.weight[k];
    light->sum += amount;
}

/// Single scattering of light that leaves towards wo.
static brushed_light brushed_once(float x, float y, rsv_vec3 wo)
{
    enum { AROUND = 48, AWAY = 48 };
    brushed_light light = { .sum = 0 };
    for (int i = 0; i < AROUND * AWAY; i++) {
        float u = ((float)(i % AROUND) + 0.5f) / AROUND, v = ((float)(i / AROUND) + 0.5f) / AWAY;
        rsv_vec3 h = rsv_ggx_sample_visible_xy(wo, x, y, u, 1 - v * v * v);
        rsv_vec3 wi = v3_sub(v3_scale(h, 2 * v3_dot(wo, h)), wo);
        if (wi.z <= 0) continue;
        double amount = 3 * (double)(v * v * rsv_ggx_visibility_xy(wo, wi, x, y));
        add_brushed_light(&light, x, y, wi, amount / (AROUND * AWAY));
    }
    return light;
}

/// Multiple scattering, of density missing(w) cos.
static brushed_light brushed_again(const rsv_brushed_rows rows, float x, float y)
{
    enum { TURNS = 64, STEPS = 128 };
    brushed_light light = { .sum = 0 };
    for (int i = 0; i < TURNS * STEPS; i++) {
        float phi = ((float)(i % TURNS) + 0.5f) / TURNS * 0.5f * RSV_PI;
        float root = ((float)(i / TURNS) + 0.5f) / STEPS, cos = root * root;
        float sin = sqrtf(1 - cos * cos);
        rsv_table_place turn = rsv_brushed_turn(x, y, cosf(phi), sinf(phi), RSV_BRUSHED_TURN);
        rsv_table_place at = rsv_table_place_at(root, RSV_BRUSHED_COS);
        float low = rsv_table_line(rows[turn.index], at);
        float missing = low + turn.weight * (rsv_table_line(rows[turn.index + 1], at) - low);
        add_brushed_light(&light, x, y, v3(sin * cosf(phi), sin * sinf(phi), cos),
            (double)(root * cos * f_max(missing, 1e-6f)));
    }
    return light;
}

static void fill_brushed_spread(
    rsv_brushed_spread spread, const rsv_brushed_rows rows, float x, float y)
{
    brushed_light again = brushed_again(rows, x, y);
    for (int i = 0; i < RSV_BRUSHED_NODES; i++) {
        float phi = brushed_azimuth(x, y, square(i / RSV_BRUSHED_NODE_COS, RSV_BRUSHED_NODE_TURNS));
        float cos = f_max(rsv_brushed_node_cos(i), 1e-5f), sin = sqrtf(1 - cos * cos);
        brushed_light once = brushed_once(x, y, v3(sin * cosf(phi), sin * sinf(phi), cos));
        double left = (1 - once.sum) / again.sum;
        for (int j = 0; j < RSV_BRUSHED_NODES; j++)
            spread[j][i] = (float)(once.at[j] + left * again.at[j]);
    }
}

static void fill_brushed(rsv_bsdf_tables *t, int a, int s)
{
    float y = f_max(square(a, RSV_BRUSHED_ALPHA), 1e-3f);
    float x = rsv_brushed_along(y, (float)s / (RSV_BRUSHED_STRENGTH - 1));
    for (int k = 0; k < RSV_BRUSHED_TURN * RSV_BRUSHED_COS; k++) {
        int turn = k / RSV_BRUSHED_COS, c = k % RSV_BRUSHED_COS;
        float phi = brushed_azimuth(x, y, square(turn, RSV_BRUSHED_TURN));
        float cos_o = f_max(square(c, RSV_BRUSHED_COS), 1e-5f);
        t->brushed_missing[a][s][turn][c] = (float)(1 - brushed_albedo(x, y, cos_o, phi));
    }
    t->brushed_missing_mean[a][s] = brushed_mean(t->brushed_missing[a][s], x, y);
    fill_brushed_spread(t->brushed_spread[a][s], t->brushed_missing[a][s], x, y);
}

/// A lobe of the sensitivities below, about `peak` nanometres and of other widths on its two sides.
static double lobe(double nm, double peak, double below, double above)
{
    double x = (nm - peak) / (nm < peak ? below : above);
    return exp(-0.5 * x * x);
}

/// Sensitivity of linear sRGB's channels, from the eye's (CIE 1931, in the form of Wyman, Sloan and Shirley 2013).
static void sensitivity(double nm, double rgb[3])
{
    double x = 1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
               0.065 * lobe(nm, 501.1, 20.4, 26.2);
    double y = 0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1);
    double z = 1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8);
    rgb[0] = 3.2404542 * x - 1.5371385 * y - 0.4985314 * z;
    rgb[1] = -0.9692660 * x + 1.8760108 * y + 0.0415560 * z;
    rgb[2] = 0.0556434 * x - 0.2040259 * y + 1.0572252 * z;
}

static void fill_film(rsv_bsdf_tables *t)
{
    enum { FROM = 330, TO = 830 };
    double whole[3] = { 0 }, rgb[3];
    for (int nm = FROM; nm <= TO; nm++) {
        sensitivity(nm, rgb);
        for (int c = 0; c < 3; c++)
            whole[c] += rgb[c];
    }
    for (int k = 0; k < RSV_FILM_STEPS; k++) {
        double path = 1000 * k / (double)RSV_FILM_STEPS_PER_UM, sum[3] = { 0 };
        for (int nm = FROM; nm <= TO; nm++) {
            double cosine = cos(2 * (double)RSV_PI * path / nm);
            sensitivity(nm, rgb);
            for (int c = 0; c < 3; c++)
                sum[c] += rgb[c] * cosine;
        }
        for (int c = 0; c < 3; c++)
            t->film_cosine[k][c] = (float)(sum[c] / whole[c]);
    }
}

/// Writes an array of `shape` (terminated by 0) with its inner braces; returns the position behind it.
static const float *print_array(FILE *file, const float *value, const int *shape)
{
    if (shape[0] == 0) {
        fprintf(file, "%.7g,", (double)*value);
        return value + 1;
    }
    fprintf(file, "{");
    for (int i = 0; i < shape[0]; i++)
        value = print_array(file, value, shape + 1);
    fprintf(file, "},\n");
    return value;
}

static void print_table(FILE *file, const char *name, const float *value, const int *shape)
{
    fprintf(file, "    .%s = ", name);
    print_array(file, value, shape);
}

static void print_tables(FILE *file, const rsv_bsdf_tables *t)
{
    const int albedo_shape[] = { 2, RSV_TABLE_ETA, RSV_TABLE_ALPHA, RSV_TABLE_COS, 0 };
    const int mean_shape[] = { 2, RSV_TABLE_ETA, RSV_TABLE_ALPHA, 0 };
    const int facet_shape[] = { RSV_FACET_COS, RSV_TABLE_ALPHA, RSV_TABLE_COS, 0 };
    const int facet_mean_shape[] = { RSV_FACET_COS, RSV_TABLE_ALPHA, 0 };
    const int brushed_shape[] = { RSV_BRUSHED_ALPHA, RSV_BRUSHED_STRENGTH, RSV_BRUSHED_TURN,
        RSV_BRUSHED_COS, 0 };
    const int brushed_mean_shape[] = { RSV_BRUSHED_ALPHA, RSV_BRUSHED_STRENGTH, 0 };
    const int brushed_spread_shape[] = { RSV_BRUSHED_ALPHA, RSV_BRUSHED_STRENGTH, RSV_BRUSHED_NODES,
        RSV_BRUSHED_NODES, 0 };
    const int film_shape[] = { RSV_FILM_STEPS, 3, 0 };
    const int spread_shape[] = { 2, RSV_TABLE_ALPHA, RSV_SPREAD_COS, RSV_SPREAD_COS, 0 };
    fprintf(file, "#include \"bsdf/tables.h\"\n\nconst rsv_bsdf_tables rsv_bsdf_tables_data = {\n");
    print_table(file, "conductor_missing", t->conductor_missing[0], albedo_shape + 2);
    print_table(file, "conductor_missing_mean", t->conductor_missing_mean, mean_shape + 2);
    print_table(file, "reflected", t->reflected[0][0], albedo_shape + 1);
    print_table(file, "reflected_mean", t->reflected_mean[0], mean_shape + 1);
    print_table(file, "missing", t->missing[0][0][0], albedo_shape);
    print_table(file, "missing_mean", t->missing_mean[0][0], mean_shape);
    print_table(file, "metal_spread", t->metal_spread[0][0], spread_shape + 1);
    print_table(file, "interface_spread", t->interface_spread[0][0][0], spread_shape);
    print_table(file, "facet", t->facet[0][0], facet_shape);
    print_table(file, "facet_mean", t->facet_mean[0], facet_mean_shape);
    print_table(file, "film_cosine", t->film_cosine[0], film_shape);
    print_table(file, "brushed_missing", t->brushed_missing[0][0][0], brushed_shape);
    print_table(file, "brushed_missing_mean", t->brushed_missing_mean[0], brushed_mean_shape);
    print_table(file, "brushed_spread", t->brushed_spread[0][0][0], brushed_spread_shape);
    fprintf(file, "};\n");
}

int main(int argc, char **argv)
{
    static rsv_bsdf_tables t;
    FILE *file = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (!file) {
        fprintf(stderr, "usage: tables_generate OUTPUT.c\n");
        return 1;
    }
    for (int a = 0; a < RSV_TABLE_ALPHA; a++) {
        for (int c = 0; c < RSV_TABLE_COS; c++)
            fill(&t, a, c);
        fill_spreads(&t, a);
        fill_means(&t, a);
    }
    fill_film(&t);
    for (int k = 0; k < RSV_BRUSHED_ALPHA * RSV_BRUSHED_STRENGTH; k++)
        fill_brushed(&t, k / RSV_BRUSHED_STRENGTH, k % RSV_BRUSHED_STRENGTH);
    print_tables(file, &t);
    return fclose(file) == 0 ? 0 : 1;
}
