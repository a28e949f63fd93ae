/// A latitude-longitude image of the sky: lookup, importance sampling, irradiance by normal.
///
/// Inline functions are also for device code.
#ifndef RSV_SKY_H
#define RSV_SKY_H

#include "../core/octahedral.h"
#include "../core/sampling.h"
#include "resolvent/scene.h"

/// The picture and how it is turned. Pixels are borrowed; NULL = black.
typedef struct rsv_sky {
    const rsv_rgb *pixel; ///< [height * width], W/(sr m2)
    uint32_t width, height;
    float turn; ///< share of a full turn about +y, counter-clockwise from above
} rsv_sky;

rsv_sky rsv_sky_from_environment(const rsv_environment *environment);

/// Place of a direction in the picture, in pixels from the top left corner.
RSV_INLINE void rsv_sky_locate(const rsv_sky *sky, rsv_vec3 direction, float *x, float *y)
{
    float u = 0.5f + atan2f(direction.z, direction.x) * (0.5f / RSV_PI) + sky->turn;
    float v =
        atan2f(sqrtf(direction.x * direction.x + direction.z * direction.z), direction.y) / RSV_PI;
    *x = (u - floorf(u)) * (float)sky->width;
    *y = v * (float)sky->height;
}

RSV_INLINE uint32_t rsv_sky_wrap(int32_t column, uint32_t width)
{
    return column < 0 ? width - 1 : (uint32_t)column < width ? (uint32_t)column : 0;
}

RSV_INLINE uint32_t rsv_sky_clamp_row(int32_t row, uint32_t height)
{
    return row < 0 ? 0 : (uint32_t)row < height ? (uint32_t)row : height - 1;
}

/// Radiance that arrives from unit `direction`, interpolated between pixel centres; the outermost half rows
/// continue to the poles.
RSV_INLINE rsv_rgb rsv_sky_radiance(const rsv_sky *sky, rsv_vec3 direction)
{
    if (!sky->pixel) return rgb_gray(0);
    float x, y;
    rsv_sky_locate(sky, direction, &x, &y);
    float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    float fx = x - 0.5f - left, fy = y - 0.5f - top;
    uint32_t c0 = rsv_sky_wrap((int32_t)left, sky->width),
             c1 = rsv_sky_wrap((int32_t)left + 1, sky->width);
    const rsv_rgb *upper =
        sky->pixel + (size_t)rsv_sky_clamp_row((int32_t)top, sky->height) * sky->width;
    const rsv_rgb *lower =
        sky->pixel + (size_t)rsv_sky_clamp_row((int32_t)top + 1, sky->height) * sky->width;
    rsv_rgb above = rgb_mad(rgb_scale(upper[c0], 1 - fx), fx, upper[c1]);
    rsv_rgb below = rgb_mad(rgb_scale(lower[c0], 1 - fx), fx, lower[c1]);
    return rgb_mad(rgb_scale(above, 1 - fy), fy, below);
}

/// The pixel that unit `direction` falls into.
RSV_INLINE void rsv_sky_pixel_at(
    const rsv_sky *sky, rsv_vec3 direction, uint32_t *column, uint32_t *row)
{
    float x, y;
    rsv_sky_locate(sky, direction, &x, &y);
    *column = (uint32_t)x < sky->width ? (uint32_t)x : sky->width - 1;
    *row = rsv_sky_clamp_row((int32_t)y, sky->height);
}

/// Solid angle of each pixel of a row.
double rsv_sky_pixel_solid_angle(const rsv_sky *sky, uint32_t row);
/// Direction to the centre of a pixel.
rsv_vec3 rsv_sky_pixel_direction(const rsv_sky *sky, uint32_t column, uint32_t row);

/// Called for patches that cover the sphere, small against a degree.
typedef void (*rsv_sky_visitor)(
    void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance);
void rsv_sky_visit(const rsv_sky *sky, rsv_sky_visitor visitor, void *user);

/// int L dw over the sphere, W/m2.
rsv_rgb rsv_sky_flux(const rsv_sky *sky);

/// Density over directions, proportional to the luminance of the interpolated picture, constant within cells of one
/// pixel (several where the picture is large) and uniform in solid angle there.
typedef struct rsv_sky_sampler {
    rsv_sky sky;
    uint32_t stride; ///< pixels along each side of a cell
    uint32_t columns, rows;
    float *row_cdf;  ///< [rows]
    float *cell_cdf; ///< [rows * columns], each row ascending to 1
    float *density;  ///< [rows * columns] per sr
    double flux;     ///< int luminance dw
} rsv_sky_sampler;

/// RSV_OK with flux 0 for a black sky, which must not be sampled.
rsv_status rsv_sky_sampler_create(
    rsv_context *context, const rsv_sky *sky, rsv_sky_sampler *sampler);
void rsv_sky_sampler_destroy(rsv_context *context, rsv_sky_sampler *sampler);

RSV_INLINE double rsv_smaller(double a, double b) { return a < b ? a : b; }

/// Cosines of the polar angle at the upper and lower edge of a row of cells.
RSV_INLINE void rsv_sky_row_edges(
    const rsv_sky_sampler *s, uint32_t row, double *upper, double *lower)
{
    double height = s->sky.height, first = (double)row * s->stride;
    *upper = cos(M_PI * first / height);
    *lower = cos(M_PI * rsv_smaller(first + s->stride, height) / height);
}

/// Left edge and width of a cell in turns.
RSV_INLINE void rsv_sky_column_edges(
    const rsv_sky_sampler *s, uint32_t column, double *left, double *width)
{
    double pixels = s->sky.width, first = (double)column * s->stride;
    *left = first / pixels;
    *width = rsv_smaller(s->stride, pixels - first) / pixels;
}

/// A direction from two numbers in [0, 1), stratified where they are. @return its density per sr
RSV_INLINE float rsv_sky_sample(
    const rsv_sky_sampler *sampler, float u1, float u2, rsv_vec3 *direction)
{
    uint32_t row = rsv_invert_cdf(sampler->row_cdf, sampler->rows, &u2);
    size_t first = (size_t)row * sampler->columns;
    uint32_t column = rsv_invert_cdf(sampler->cell_cdf + first, sampler->columns, &u1);
    double upper, lower, left, width;
    rsv_sky_row_edges(sampler, row, &upper, &lower);
    rsv_sky_column_edges(sampler, column, &left, &width);
    double height = upper + u2 * (lower - upper), radius = sqrt(fmax(1 - height * height, 0.0));
    double phi = 2 * M_PI * (left + u1 * width - 0.5 - sampler->sky.turn);
    *direction = v3((float)(radius * cos(phi)), (float)height, (float)(radius * sin(phi)));
    return sampler->density[first + column];
}

/// Density of rsv_sky_sample.
RSV_INLINE float rsv_sky_pdf(const rsv_sky_sampler *sampler, rsv_vec3 direction)
{
    if (!(sampler->flux > 0)) return 0;
    uint32_t x, y;
    rsv_sky_pixel_at(&sampler->sky, direction, &x, &y);
    return sampler->density[(size_t)(y / sampler->stride) * sampler->columns + x / sampler->stride];
}

/// Irradiance without occlusion by the normal of the receiver: a table over the octahedral square.
typedef struct rsv_sky_irradiance {
    rsv_rgb *node; ///< [RSV_SKY_IRRADIANCE_NODES^2], NULL = black
} rsv_sky_irradiance;

#define RSV_SKY_IRRADIANCE_SIDE 128
#define RSV_SKY_IRRADIANCE_NODES (RSV_SKY_IRRADIANCE_SIDE + 1)

rsv_status rsv_sky_irradiance_create(
    rsv_context *context, const rsv_sky *sky, rsv_sky_irradiance *irradiance);
void rsv_sky_irradiance_destroy(rsv_context *context, rsv_sky_irradiance *irradiance);
/// @param normal unit
RSV_INLINE rsv_rgb rsv_sky_irradiance_at(const rsv_sky_irradiance *irradiance, rsv_vec3 normal)
{
    if (!irradiance->node) return rgb_gray(0);
    float x, y;
    rsv_octahedral_from_direction(normal, &x, &y);
    x *= RSV_SKY_IRRADIANCE_SIDE;
    y *= RSV_SKY_IRRADIANCE_SIDE;
    uint32_t i = (uint32_t)x, j = (uint32_t)y;
    i = i < RSV_SKY_IRRADIANCE_SIDE ? i : RSV_SKY_IRRADIANCE_SIDE - 1;
    j = j < RSV_SKY_IRRADIANCE_SIDE ? j : RSV_SKY_IRRADIANCE_SIDE - 1;
    float fx = x - (float)i, fy = y - (float)j;
    const rsv_rgb *node = irradiance->node + (size_t)j * RSV_SKY_IRRADIANCE_NODES + i;
    rsv_rgb above = rgb_mad(rgb_scale(node[0], 1 - fx), fx, node[1]);
    rsv_rgb below = rgb_mad(
        rgb_scale(node[RSV_SKY_IRRADIANCE_NODES], 1 - fx), fx, node[RSV_SKY_IRRADIANCE_NODES + 1]);
    return rgb_mad(rgb_scale(above, 1 - fy), fy, below);
}

#endif
