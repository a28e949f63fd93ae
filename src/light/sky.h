/// A latitude-longitude picture of the sky: lookup, importance sampling, irradiance by normal.
#ifndef RSV_SKY_H
#define RSV_SKY_H

#include "../core/sampling.h"
#include "resolvent/scene.h"

/// The picture and how it is turned. Pixels are borrowed; NULL = black.
typedef struct rsv_sky {
    const rsv_rgb *pixel; ///< [height * width], W/(sr m2)
    uint32_t width, height;
    float turn; ///< share of a full turn about +y, counter-clockwise from above
} rsv_sky;

rsv_sky rsv_sky_from_environment(const rsv_environment *environment);

/// Radiance that arrives from unit `direction`, interpolated between pixel centres; the outermost half rows
/// continue to the poles.
rsv_rgb rsv_sky_radiance(const rsv_sky *sky, rsv_vec3 direction);

/// The pixel that unit `direction` falls into.
void rsv_sky_pixel_at(const rsv_sky *sky, rsv_vec3 direction, uint32_t *column, uint32_t *row);
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

/// A direction from two numbers in [0, 1), stratified where they are. @return its density per sr
float rsv_sky_sample(const rsv_sky_sampler *sampler, float u1, float u2, rsv_vec3 *direction);
float rsv_sky_pdf(const rsv_sky_sampler *sampler, rsv_vec3 direction);

/// Irradiance without occlusion by the normal of the receiver: a table over the octahedral square.
typedef struct rsv_sky_irradiance {
    rsv_rgb *node; ///< [(RSV_SKY_IRRADIANCE_SIDE + 1)^2], NULL = black
} rsv_sky_irradiance;

#define RSV_SKY_IRRADIANCE_SIDE 128

rsv_status rsv_sky_irradiance_create(
    rsv_context *context, const rsv_sky *sky, rsv_sky_irradiance *irradiance);
void rsv_sky_irradiance_destroy(rsv_context *context, rsv_sky_irradiance *irradiance);
/// @param normal unit
rsv_rgb rsv_sky_irradiance_at(const rsv_sky_irradiance *irradiance, rsv_vec3 normal);

#endif
