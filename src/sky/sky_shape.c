/// How luminance is spread over the sky: the CIE's standard skies and that of Perez et al.
#include "../core/core.h"
#include "../core/vec.h"
#include "resolvent/sky.h"

#include <math.h>

#define DEGREES (M_PI / 180)
#define SOLAR_CONSTANT 1367.0      ///< W/m2, as the model was fitted
#define SOLAR_ILLUMINANCE 127500.0 ///< lux
#define USUAL_DEW_POINT 11.0
#define STEEPEST 20 ///< some Perez skies grow without bounds at the horizon

/// Table 1 of ISO 15469:2004: a, b, c, d, e of types 1 to 15.
static const double cie_types[RSV_CIE_SKY_TYPES][5] = { { 4.0, -0.70, 0, -1.0, 0 },
    { 4.0, -0.70, 2, -1.5, 0.15 }, { 1.1, -0.8, 0, -1.0, 0 }, { 1.1, -0.8, 2, -1.5, 0.15 },
    { 0, -1.0, 0, -1.0, 0 }, { 0, -1.0, 2, -1.5, 0.15 }, { 0, -1.0, 5, -2.5, 0.30 },
    { 0, -1.0, 10, -3.0, 0.45 }, { -1.0, -0.55, 2, -1.5, 0.15 }, { -1.0, -0.55, 5, -2.5, 0.30 },
    { -1.0, -0.55, 10, -3.0, 0.45 }, { -1.0, -0.32, 10, -3.0, 0.45 },
    { -1.0, -0.32, 16, -3.0, 0.30 }, { -1.0, -0.15, 16, -3.0, 0.30 },
    { -1.0, -0.15, 24, -2.8, 0.15 } };

rsv_sky_shape rsv_cie_sky(int type, rsv_vec3 sun)
{
    if (type == RSV_CIE_TRADITIONAL_OVERCAST) return (rsv_sky_shape){ .linear = true, .sun = sun };
    int row = type < 1 ? 0 : type > RSV_CIE_SKY_TYPES ? RSV_CIE_SKY_TYPES - 1 : type - 1;
    const double *p = cie_types[row];
    return (rsv_sky_shape){ p[0], p[1], p[2], p[3], p[4], -exp(p[3] * M_PI / 2), sun, false };
}

/// 1 + a exp(b / cos Z), which has a limit at the horizon.
static double gradation(const rsv_sky_shape *s, double up)
{
    return 1 + s->a * exp(fmin(s->b / fmax(up, 1e-6), STEEPEST));
}

double rsv_sky_shape_at(const rsv_sky_shape *s, rsv_vec3 direction)
{
    if (s->linear) return (1 + 2 * fmax((double)direction.y, 0)) / 3;
    double cosine = (double)v3_dot(direction, s->sun);
    cosine = fmin(fmax(cosine, -1), 1);
    double indicatrix = 1 + s->c * (exp(s->d * acos(cosine)) + s->f) + s->e * cosine * cosine;
    return fmax(gradation(s, (double)direction.y) * indicatrix, 0);
}

/// One of the eight categories of clearness: up to which, the parameters of shape (1993, table 1; four coefficients for
/// each of a to e) and those of luminous efficacies (1990, table 4; diffuse, direct).
typedef struct category {
    double most, shape[5][4], diffuse[4], direct[4];
} category;

static const category categories[8] = {
    { 1.065,
        { { 1.3525, -0.2576, -0.2690, -1.4366 }, { -0.7670, 0.0007, 1.2734, -0.1233 },
            { 2.8000, 0.6004, 1.2375, 1.0000 }, { 1.8734, 0.6297, 0.9738, 0.2809 },
            { 0.0356, -0.1246, -0.5718, 0.9938 } },
        { 97.24, -0.46, 12.00, -8.91 }, { 57.20, -4.55, -2.98, 117.12 } },
    { 1.230,
        { { -1.2219, -0.7730, 1.4148, 1.1016 }, { -0.2054, 0.0367, -3.9128, 0.9156 },
            { 6.9750, 0.1774, 6.4477, -0.1239 }, { -1.5798, -0.5081, -1.7812, 0.1080 },
            { 0.2624, 0.0672, -0.2190, -0.4285 } },
        { 107.22, 1.15, 0.59, -3.95 }, { 98.99, -3.46, -1.21, 12.38 } },
    { 1.500,
        { { -1.1000, -0.2515, 0.8952, 0.0156 }, { 0.2782, -0.1812, -4.5000, 1.1766 },
            { 24.7219, -13.0812, -37.7000, 34.8438 }, { -5.0000, 1.5218, 3.9229, -2.6204 },
            { -0.0156, 0.1597, 0.4199, -0.5562 } },
        { 104.97, 2.96, -5.53, -8.77 }, { 109.83, -4.90, -1.71, -8.81 } },
    { 1.950,
        { { -0.5484, -0.6654, -0.2672, 0.7117 }, { 0.7234, -0.6219, -5.6812, 2.6297 },
            { 33.3389, -18.3000, -62.2500, 52.0781 }, { -3.5000, 0.0016, 1.1477, 0.1062 },
            { 0.4659, -0.3296, -0.0876, -0.0329 } },
        { 102.39, 5.59, -13.95, -13.90 }, { 110.34, -5.84, -1.99, -4.56 } },
    { 2.800,
        { { -0.6000, -0.3566, -2.5000, 2.3250 }, { 0.2937, 0.0496, -5.6812, 1.8415 },
            { 21.0000, -4.7656, -21.5906, 7.2492 }, { -3.5000, -0.1554, 1.4062, 0.3988 },
            { 0.0032, 0.0766, -0.0656, -0.1294 } },
        { 100.71, 5.94, -22.75, -23.74 }, { 106.36, -3.97, -1.75, -6.16 } },
    { 4.500,
        { { -1.0156, -0.3670, 1.0078, 1.4051 }, { 0.2875, -0.5328, -3.8500, 3.3750 },
            { 14.0000, -0.9999, -7.1406, 7.5469 }, { -3.4000, -0.1078, -1.0750, 1.5702 },
            { -0.0672, 0.4016, 0.3017, -0.4844 } },
        { 106.42, 3.83, -36.15, -28.83 }, { 107.19, -1.25, -1.51, -26.73 } },
    { 6.200,
        { { -1.0000, 0.0211, 0.5025, -0.5119 }, { -0.3000, 0.1922, 0.7023, -1.6317 },
            { 19.0000, -5.0000, 1.2438, -1.9094 }, { -4.0000, 0.0250, 0.3844, 0.2656 },
            { 1.0468, -0.3788, -2.4517, 1.4656 } },
        { 141.88, 1.90, -53.24, -14.03 }, { 105.75, 0.77, -1.26, -34.44 } },
    { INFINITY,
        { { -1.0500, 0.0289, 0.4260, 0.3590 }, { -0.3250, 0.1156, 0.7781, 0.0025 },
            { 31.0625, -14.5000, -46.1148, 55.3750 }, { -7.2312, 0.4050, 13.3500, 0.6234 },
            { 1.5000, -0.6426, 1.8564, 0.5636 } },
        { 152.23, 0.35, -45.27, -7.98 }, { 101.18, 1.58, -1.10, -8.29 } },
};

/// Input of the sky model at one moment.
typedef struct sky_state {
    double zenith; ///< of the sun, radians
    double clearness, brightness, water;
    const category *in;
} sky_state;

/// By which the Earth's distance makes the sun stronger than in the mean (Spencer 1971).
static double eccentricity(int day_of_year)
{
    double x = 2 * M_PI * (day_of_year - 1) / 365;
    return 1.00011 + 0.034221 * cos(x) + 0.00128 * sin(x) + 0.000719 * cos(2 * x) +
           0.000077 * sin(2 * x);
}

/// Relative optical air mass (Kasten 1966).
static double air_mass(double zenith)
{
    return 1 / (cos(zenith) + 0.15 * pow(93.885 - zenith / DEGREES, -1.253));
}

static sky_state state_of(const rsv_irradiance_record *r, rsv_vec3 sun)
{
    sky_state s;
    double elevation = asin(fmin(fmax((double)sun.y, -1), 1));
    double dew_point = isfinite(r->dew_point) ? r->dew_point : USUAL_DEW_POINT;
    s.zenith = M_PI / 2 - fmin(fmax(elevation, 0), 87 * DEGREES);
    double cube = 1.041 * s.zenith * s.zenith * s.zenith;
    double diffuse = fmax(r->diffuse_horizontal, 1e-6), direct = fmax(r->direct_normal, 0);
    s.clearness = ((diffuse + direct) / diffuse + cube) / (1 + cube);
    s.clearness = fmin(fmax(s.clearness, 1), 11.9);
    s.brightness = diffuse * air_mass(s.zenith) / (SOLAR_CONSTANT * eccentricity(r->day_of_year));
    s.brightness = fmin(fmax(s.brightness, 0.01), 0.6);
    s.water = exp(0.07 * dew_point - 0.075);
    s.in = categories;
    while (s.clearness >= s.in->most)
        s.in++;
    return s;
}

static double diffuse_efficacy(const sky_state *s)
{
    const double *k = s->in->diffuse;
    return k[0] + k[1] * s->water + k[2] * cos(s->zenith) + k[3] * log(s->brightness);
}

static double direct_efficacy(const sky_state *s)
{
    const double *k = s->in->direct;
    return fmax(
        k[0] + k[1] * s->water + k[2] * exp(5.73 * s->zenith - 5) + k[3] * s->brightness, 0);
}

static rsv_sky_shape shape_of(const sky_state *s, rsv_vec3 sun)
{
    double x[5], z = s->zenith, delta = s->brightness;
    if (s->clearness > 1.065 && s->clearness < 2.8) delta = fmax(delta, 0.2);
    for (int k = 0; k < 5; k++) {
        const double *p = s->in->shape[k];
        x[k] = p[0] + p[1] * z + delta * (p[2] + p[3] * z);
    }
    if (s->in == categories) { // c and d have forms of their own under overcast skies
        const double *c = s->in->shape[2], *d = s->in->shape[3];
        x[2] = exp(pow(delta * (c[0] + c[1] * z), c[2])) - c[3];
        x[3] = -exp(delta * (d[0] + d[1] * z)) + d[2] + delta * d[3];
    }
    // the model's sun is never below the horizon, nor at the zenith
    double across = hypot((double)sun.x, (double)sun.z), turn = across > 0 ? sin(z) / across : 0;
    rsv_vec3 place = { (float)(turn * (double)sun.x), (float)cos(z),
        (float)(turn * (double)sun.z) };
    if (!(across > 0)) place.z = (float)sin(z);
    return (rsv_sky_shape){ x[0], x[1], x[2], x[3], x[4], 0, place, false };
}

static rsv_perez_sky sky_of(const sky_state *s, double diffuse, double direct, rsv_vec3 sun)
{
    return (rsv_perez_sky){ shape_of(s, sun), s->clearness, s->brightness, diffuse, direct };
}

rsv_perez_sky rsv_perez_sky_of(const rsv_irradiance_record *r, rsv_vec3 sun)
{
    sky_state s = state_of(r, sun);
    return sky_of(&s, fmax(r->diffuse_horizontal, 0) * diffuse_efficacy(&s),
        fmax(r->direct_normal, 0) * direct_efficacy(&s), sun);
}

rsv_perez_sky rsv_perez_sky_of_illuminance(
    double diffuse, double direct, const rsv_irradiance_record *record, rsv_vec3 sun)
{
    const double usual = SOLAR_CONSTANT / SOLAR_ILLUMINANCE;
    rsv_irradiance_record r = *record;
    r.diffuse_horizontal = diffuse * usual;
    r.direct_normal = direct * usual;
    sky_state s = state_of(&r, sun);
    for (int k = 0; k < 8; k++) { // categories are steps: it need not settle, and need not
        double efficacy = direct_efficacy(&s);
        r.diffuse_horizontal = diffuse / diffuse_efficacy(&s);
        r.direct_normal = efficacy > 1 ? direct / efficacy : 0;
        s = state_of(&r, sun);
    }
    return sky_of(&s, diffuse, direct, sun);
}
