#include "../core/core.h"
#include "../core/vec.h"
#include "resolvent/sky.h"

#include <math.h>

#define ROWS 7
static const uint32_t tregenza[ROWS] = { 30, 30, 24, 24, 18, 12, 6 };

/// A row of patches.
typedef struct patch_row {
    uint32_t first, count;
    double low, high; ///< elevation of its edges, radians
} patch_row;

/// Elevation that a row takes.
static double height_of(const rsv_sky_patches *p)
{
    return M_PI / 2 / (ROWS * p->subdivision + 0.5);
}

/// @param row up to that of the zenith, ROWS * subdivision
static patch_row row_at(const rsv_sky_patches *p, uint32_t row)
{
    uint32_t first = 1, m = p->subdivision;
    double height = height_of(p);
    if (row == ROWS * m) return (patch_row){ p->count - 1, 1, row * height, M_PI / 2 };
    for (uint32_t k = 0; k < row / m; k++)
        first += tregenza[k] * m * m;
    uint32_t count = tregenza[row / m] * m;
    return (patch_row){ first + row % m * count, count, row * height, (row + 1) * height };
}

static patch_row row_of(const rsv_sky_patches *p, uint32_t patch)
{
    uint32_t first = 1, m = p->subdivision;
    if (patch + 1 >= p->count) return row_at(p, ROWS * m);
    for (uint32_t k = 0; k < ROWS; k++) {
        uint32_t in_band = tregenza[k] * m * m;
        if (patch < first + in_band) return row_at(p, k * m + (patch - first) / (tregenza[k] * m));
        first += in_band;
    }
    return row_at(p, ROWS * m);
}

static double middle_of(const patch_row *row)
{
    return row->count == 1 ? M_PI / 2 : (row->low + row->high) / 2;
}

static double solid_angle_of(const patch_row *row)
{
    // a difference of sines that keeps its digits at the zenith
    double half = (row->high - row->low) / 2, middle = (row->high + row->low) / 2;
    return 2 * M_PI * 2 * cos(middle) * sin(half) / row->count;
}

rsv_sky_patches rsv_sky_patches_of(uint32_t m)
{
    m = m < 1 ? 1 : m > RSV_SKY_MOST_SUBDIVISIONS ? RSV_SKY_MOST_SUBDIVISIONS : m;
    return (rsv_sky_patches){ m, 144 * m * m + 2 };
}

uint32_t rsv_sky_patch_at(const rsv_sky_patches *p, rsv_vec3 direction)
{
    double x = (double)direction.x, y = (double)direction.y, z = (double)direction.z;
    if (!(y >= 0)) return 0;
    uint32_t last = ROWS * p->subdivision, row = (uint32_t)(atan2(y, hypot(x, z)) / height_of(p));
    if (row >= last) return p->count - 1;
    patch_row r = row_at(p, row);
    double turn =
        atan2(x, -z) / (2 * M_PI) * r.count + 0.5; // middles are at multiples of the width
    if (turn < 0) turn += r.count;
    return r.first + (uint32_t)turn % r.count;
}

rsv_vec3 rsv_sky_patch_direction(const rsv_sky_patches *p, uint32_t patch)
{
    if (patch == 0) return v3(0, -1, 0);
    patch_row r = row_of(p, patch);
    double elevation = middle_of(&r), azimuth = 2 * M_PI * (patch - r.first) / r.count;
    return v3((float)(cos(elevation) * sin(azimuth)), (float)sin(elevation),
        (float)(-cos(elevation) * cos(azimuth)));
}

double rsv_sky_patch_solid_angle(const rsv_sky_patches *p, uint32_t patch)
{
    if (patch == 0) return 2 * M_PI;
    patch_row r = row_of(p, patch);
    return solid_angle_of(&r);
}

/// Fills a row with the shape at its middles. @return the horizontal illuminance of that
static double shape_row(const rsv_sky_shape *shape, const patch_row *row, float *luminance)
{
    double elevation = middle_of(row), step = 2 * M_PI / row->count, sum = 0;
    double across = cos(elevation), up = sin(elevation), c = cos(step), s = sin(step);
    double x = 0, z = -across; // turned step by step
    for (uint32_t k = 0; k < row->count; k++) {
        double value = rsv_sky_shape_at(shape, v3((float)x, (float)up, (float)z));
        luminance[row->first + k] = (float)value;
        sum += value;
        double turned = x * c - z * s;
        z = x * s + z * c;
        x = turned;
    }
    return sum * up * solid_angle_of(row);
}

void rsv_sky_patch_luminances(
    const rsv_sky_patches *p, const rsv_sky_shape *shape, double illuminance, float *luminance)
{
    double sum = 0;
    for (uint32_t row = 0; row <= ROWS * p->subdivision; row++) {
        patch_row r = row_at(p, row);
        sum += shape_row(shape, &r, luminance);
    }
    bool even = !(sum > 1e-9) || !isfinite(sum);
    double scale = even ? illuminance / M_PI : illuminance / sum;
    for (uint32_t k = 1; k < p->count; k++)
        luminance[k] = (float)(even ? scale : scale * (double)luminance[k]);
}
