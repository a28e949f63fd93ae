#include "case_sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Pixels of 0.35 degrees; each holds the mean over subdivisions, as discs and horizons have edges.
#define SKY_WIDTH 1024
#define SKY_HEIGHT 512
#define SUBDIVISIONS 2
#define EDGE_SUBDIVISIONS 24

static void read_numbers(const cJSON *json, double *value, int count)
{
    for (int i = 0; i < count && cJSON_IsArray(json); i++)
        value[i] = cJSON_GetNumberValue(cJSON_GetArrayItem(json, i));
}

static double number(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItem(json, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0;
}

/// Gradation with the zenith angle.
static double gradation(const double *abcde, double cos_zenith)
{
    return 1 + abcde[0] * exp(abcde[1] / cos_zenith);
}

/// Scattering indicatrix at an angle from the sun.
static double indicatrix(const double *abcde, double cos_sun)
{
    double angle = acos(fmin(fmax(cos_sun, -1), 1));
    return 1 + abcde[2] * (exp(abcde[3] * angle) - exp(abcde[3] * M_PI / 2)) +
           abcde[4] * cos_sun * cos_sun;
}

static double general_radiance(const case_sky *sky, const double *d, double cos_axis)
{
    return sky->radiance * indicatrix(sky->abcde, cos_axis) * gradation(sky->abcde, d[2]) /
           (indicatrix(sky->abcde, sky->axis[2]) * gradation(sky->abcde, 1));
}

static double harmonics(const double *l, const double *d)
{
    double x = d[0], y = d[1], z = d[2], band1 = sqrt(3 / (4 * M_PI)), band2 = sqrt(15 / M_PI) / 2;
    return l[0] * sqrt(1 / (4 * M_PI)) + band1 * (l[1] * y + l[2] * z + l[3] * x) +
           band2 * (l[4] * x * y + l[5] * y * z + l[7] * x * z) +
           l[6] * sqrt(5 / M_PI) / 4 * (3 * z * z - 1) + l[8] * band2 / 2 * (x * x - y * y);
}

static double radiance_at(const case_sky *sky, const double *d)
{
    double cos_axis = d[0] * sky->axis[0] + d[1] * sky->axis[1] + d[2] * sky->axis[2];
    bool daylight = sky->kind == CASE_SKY_OVERCAST || sky->kind == CASE_SKY_GENERAL;
    if (daylight && d[2] <= 0) return sky->ground;
    switch (sky->kind) {
    case CASE_SKY_CONSTANT:
        return sky->radiance;
    case CASE_SKY_UPPER:
        return d[2] > 0 ? sky->radiance : 0;
    case CASE_SKY_DISC:
        return cos_axis >= sky->cos_radius ? sky->radiance : 0;
    case CASE_SKY_LOBE:
        return sky->radiance * pow(fmax(cos_axis, 0), sky->exponent);
    case CASE_SKY_OVERCAST:
        return sky->radiance * (1 + 2 * d[2]) / 3;
    case CASE_SKY_GENERAL:
        return general_radiance(sky, d, cos_axis);
    case CASE_SKY_HARMONICS:
        return harmonics(sky->harmonic, d);
    default:
        return 0;
    }
}

/// Some sets of harmonics are negative in places: test functions rather than skies.
static bool is_positive(const case_sky *sky)
{
    for (int k = 0; k < 4096; k++) {
        double z = 1 - (k + 0.5) / 2048, r = sqrt(1 - z * z), phi = 2.399963229728653 * k;
        double d[3] = { r * cos(phi), r * sin(phi), z };
        if (radiance_at(sky, d) < 0) return false;
    }
    return true;
}

bool case_sky_read(const cJSON *json, case_sky *sky)
{
    static const char *const kinds[] = { [CASE_SKY_CONSTANT] = "constant",
        [CASE_SKY_UPPER] = "upper_hemisphere",
        [CASE_SKY_DISC] = "disc",
        [CASE_SKY_LOBE] = "cosine_lobe",
        [CASE_SKY_OVERCAST] = "cie_overcast",
        [CASE_SKY_GENERAL] = "cie_general",
        [CASE_SKY_HARMONICS] = "sh9" };
    const char *type = cJSON_GetStringValue(cJSON_GetObjectItem(json, "type"));
    *sky = (case_sky){ .axis = { 0, 0, 1 } };
    for (int kind = CASE_SKY_CONSTANT; type && kind <= CASE_SKY_HARMONICS; kind++)
        if (strcmp(kinds[kind], type) == 0) sky->kind = (case_sky_kind)kind;
    sky->radiance = number(json, "radiance") + number(json, "zenith_radiance");
    sky->ground = number(json, "ground_radiance");
    sky->cos_radius = cos(number(json, "angular_radius_deg") * M_PI / 180);
    sky->exponent = number(json, "exponent");
    read_numbers(cJSON_GetObjectItem(json, "axis"), sky->axis, 3);
    read_numbers(cJSON_GetObjectItem(json, "direction"), sky->axis, 3);
    read_numbers(cJSON_GetObjectItem(json, "sun_direction"), sky->axis, 3);
    read_numbers(cJSON_GetObjectItem(json, "abcde"), sky->abcde, 5);
    read_numbers(cJSON_GetObjectItem(json, "coefficients"), sky->harmonic, 9);
    return sky->kind != CASE_SKY_NONE && is_positive(sky);
}

static void direction_at(double u, double v, double *d)
{
    double phi = 2 * M_PI * (u - 0.5), theta = M_PI * v;
    d[0] = sin(theta) * cos(phi), d[1] = cos(theta), d[2] = sin(theta) * sin(phi);
}

/// Only discs have edges that do not run between pixels.
static int subdivisions(const case_sky *sky, int column, int row)
{
    double d[3];
    direction_at((column + 0.5) / SKY_WIDTH, (row + 0.5) / SKY_HEIGHT, d);
    double cosine = d[0] * sky->axis[0] + d[1] * sky->axis[1] + d[2] * sky->axis[2];
    double from_edge = fabs(acos(fmin(fmax(cosine, -1), 1)) - acos(sky->cos_radius));
    bool edge = sky->kind == CASE_SKY_DISC && from_edge < 2 * M_PI / SKY_HEIGHT;
    return edge ? EDGE_SUBDIVISIONS : SUBDIVISIONS;
}

/// Mean over a pixel.
static float pixel_radiance(const case_sky *sky, int column, int row)
{
    double sum = 0, weight = 0;
    int side = subdivisions(sky, column, row);
    for (int k = 0; k < side * side; k++) {
        double u = (column + (k % side + 0.5) / side) / SKY_WIDTH, d[3];
        double v = (row + ((double)(k / side) + 0.5) / side) / SKY_HEIGHT;
        direction_at(u, v, d);
        sum += sin(M_PI * v) * radiance_at(sky, d);
        weight += sin(M_PI * v);
    }
    return (float)(sum / weight);
}

rsv_status case_sky_add(rsv_scene *scene, const case_sky *sky)
{
    if (sky->kind == CASE_SKY_NONE) return RSV_OK;
    rsv_rgb *pixels = malloc((size_t)SKY_WIDTH * SKY_HEIGHT * sizeof *pixels);
    if (!pixels) abort();
#pragma omp parallel for
    for (int row = 0; row < SKY_HEIGHT; row++) {
        for (int column = 0; column < SKY_WIDTH; column++) {
            float radiance = pixel_radiance(sky, column, row);
            pixels[row * SKY_WIDTH + column] = (rsv_rgb){ radiance, radiance, radiance };
        }
    }
    rsv_environment environment = {
        .name = "case", .pixels = pixels, .width = SKY_WIDTH, .height = SKY_HEIGHT, .intensity = 1
    };
    rsv_status status = rsv_scene_set_environment(scene, &environment);
    free(pixels);
    return status;
}
