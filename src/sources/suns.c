/// Suns: strong, small, bright regions of a picture of the sky, found by growing them from the brightest pixel.
#include "../core/core.h"
#include "environment.h"

/// A sun's brightest pixel exceeds the rest of the sky by this factor, on average over the sphere,
#define SUN_CONTRAST 200
/// its pixels are not dimmer than this share of that,
#define SUN_EDGE 0.02f
/// all of them within this angle of it,
#define COS_SUN_RADIUS 0.9986f // 3 degrees
/// and it sends this share of the light at least.
#define SUN_SHARE 0.02

typedef struct region {
    const rsv_sky *sky;
    rsv_rgb *pixel;
    uint8_t *inside;  ///< [height * width]
    uint32_t *member; ///< [height * width] at most
    size_t count;
    float edge; ///< luminance from which a pixel belongs
    rsv_vec3 peak;
} region;

static size_t brightest_pixel(const rsv_sky *sky, const rsv_rgb *pixel)
{
    size_t brightest = 0;
    for (size_t i = 1; i < (size_t)sky->width * sky->height; i++)
        if (rgb_luminance(pixel[i]) > rgb_luminance(pixel[brightest])) brightest = i;
    return brightest;
}

/// Flux of everything, bright pixels counted as no more than `limit`.
static double limited_flux(const rsv_sky *sky, const rsv_rgb *pixel, float limit)
{
    double sum = 0;
    for (uint32_t y = 0; y < sky->height; y++) {
        double row = 0;
        for (uint32_t x = 0; x < sky->width; x++)
            row += f_min(rgb_luminance(pixel[(size_t)y * sky->width + x]), limit);
        sum += row * rsv_sky_pixel_solid_angle(sky, y);
    }
    return sum;
}

/// Pixel `step` of the eight around `index`; RSV_NONE beyond a pole.
static uint32_t neighbour(const rsv_sky *sky, uint32_t index, int step)
{
    int32_t width = (int32_t)sky->width, row = (int32_t)(index / sky->width) + step / 3 - 1;
    int32_t column = ((int32_t)(index % sky->width) + step % 3 - 1 + width) % width;
    if (row < 0 || row >= (int32_t)sky->height) return RSV_NONE;
    return (uint32_t)row * sky->width + (uint32_t)column;
}

static void include(region *r, uint32_t index)
{
    r->inside[index] = 1;
    r->member[r->count++] = index;
}

/// False if the region is too wide for a sun.
static bool grow(region *r, uint32_t seed)
{
    const rsv_sky *sky = r->sky;
    r->peak = rsv_sky_pixel_direction(sky, seed % sky->width, seed / sky->width);
    include(r, seed);
    for (size_t k = 0; k < r->count; k++) {
        for (int step = 0; step < 9; step++) {
            uint32_t index = neighbour(sky, r->member[k], step);
            if (index == RSV_NONE || r->inside[index]) continue;
            if (rgb_luminance(r->pixel[index]) < r->edge) continue;
            rsv_vec3 direction =
                rsv_sky_pixel_direction(sky, index % sky->width, index / sky->width);
            if (v3_dot(direction, r->peak) < COS_SUN_RADIUS) return false;
            include(r, index);
        }
    }
    return true;
}

/// Mean radiance of the pixels around the region.
static rsv_rgb surrounding_radiance(const region *r)
{
    double sum[3] = { 0 };
    size_t count = 0;
    for (size_t k = 0; k < r->count; k++) {
        for (int step = 0; step < 9; step++) {
            uint32_t index = neighbour(r->sky, r->member[k], step);
            if (index == RSV_NONE || r->inside[index]) continue;
            sum[0] += r->pixel[index].r, sum[1] += r->pixel[index].g, sum[2] += r->pixel[index].b;
            count++;
        }
    }
    double scale = count ? 1 / (double)count : 0;
    return rgb((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale));
}

static rsv_rgb excess(rsv_rgb value, rsv_rgb base) { return rgb_positive(rgb_sub(value, base)); }

/// The disc of the same flux, the same mean direction, and the solid angle (int L dw)^2 / int L^2 dw.
static rsv_sun measure(const region *r, rsv_rgb base)
{
    double flux[3] = { 0 }, axis[3] = { 0 }, luminance_flux = 0, squares = 0;
    for (size_t k = 0; k < r->count; k++) {
        uint32_t column = r->member[k] % r->sky->width, row = r->member[k] / r->sky->width;
        double solid_angle = rsv_sky_pixel_solid_angle(r->sky, row);
        rsv_rgb value = excess(r->pixel[r->member[k]], base);
        double luminance = rgb_luminance(value);
        rsv_vec3 direction = rsv_sky_pixel_direction(r->sky, column, row);
        flux[0] += value.r * solid_angle, flux[1] += value.g * solid_angle;
        flux[2] += value.b * solid_angle;
        axis[0] += luminance * solid_angle * direction.x;
        axis[1] += luminance * solid_angle * direction.y;
        axis[2] += luminance * solid_angle * direction.z;
        luminance_flux += luminance * solid_angle;
        squares += luminance * luminance * solid_angle;
    }
    double solid_angle = luminance_flux * luminance_flux / squares;
    double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    return (rsv_sun){ .direction = v3((float)(axis[0] / length), (float)(axis[1] / length),
                          (float)(axis[2] / length)),
        .radiance = rgb((float)(flux[0] / solid_angle), (float)(flux[1] / solid_angle),
            (float)(flux[2] / solid_angle)),
        .cos_radius = (float)(1 - solid_angle / (2 * M_PI)),
        .solid_angle = (float)solid_angle };
}

static void clear_region(region *r)
{
    for (size_t k = 0; k < r->count; k++)
        r->inside[r->member[k]] = 0;
    r->count = 0;
}

/// Takes one sun out; false if there is none.
static bool extract_one(region *r, rsv_sun *sun)
{
    uint32_t seed = (uint32_t)brightest_pixel(r->sky, r->pixel);
    float peak = rgb_luminance(r->pixel[seed]);
    double total = limited_flux(r->sky, r->pixel, INFINITY);
    double rest = limited_flux(r->sky, r->pixel, peak * SUN_EDGE);
    r->edge = peak * SUN_EDGE;
    if (!(peak * 4 * M_PI > SUN_CONTRAST * rest) || !grow(r, seed)) return false;
    rsv_rgb base = surrounding_radiance(r);
    *sun = measure(r, base);
    if (!(rgb_luminance(sun->radiance) * sun->solid_angle >= SUN_SHARE * total)) return false;
    for (size_t k = 0; k < r->count; k++) {
        rsv_rgb *value = &r->pixel[r->member[k]];
        *value = rgb_sub(*value, excess(*value, base));
    }
    return true;
}

rsv_status rsv_extract_suns(
    rsv_context *context, const rsv_sky *sky, rsv_rgb *pixels, rsv_sun *sun, uint32_t *count)
{
    size_t pixel_count = (size_t)sky->width * sky->height;
    region r = { .sky = sky, .pixel = pixels };
    r.inside = rsv_alloc(context, pixel_count, sizeof *r.inside);
    r.member = rsv_alloc(context, pixel_count, sizeof *r.member);
    rsv_status status = r.inside && r.member ? RSV_OK : RSV_ERROR_MEMORY;
    *count = 0;
    while (status == RSV_OK && *count < RSV_MAX_SUNS && extract_one(&r, &sun[*count])) {
        clear_region(&r);
        ++*count;
    }
    rsv_free(context, r.inside);
    rsv_free(context, r.member);
    return status;
}
