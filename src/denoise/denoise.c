#include "denoise.h"

#include "denoise_constants.h"
#include "window.h"

#define LIGHT_PLANES 13
#define ALL_PLANES (SURFACE_PLANES + RSV_KINDS_OF_LIGHT * LIGHT_PLANES + 1)

/// Light that first surfaces reflect diffusely, by albedo, and all other.
enum { DIFFUSE, OTHER };

typedef struct filter {
    rsv_plane_grid grid;
    const rsv_denoise_half *half;
    rsv_surface_planes surfaces;
    rsv_light_planes light[RSV_KINDS_OF_LIGHT];
    float *variance; ///< [plane] of a half, by one pixel alone
    int kind;        ///< of the light at hand
    rsv_rgb *const *filtered;
} filter;

static void lay_out(filter *f, float *planes)
{
    size_t size = rsv_plane_size(&f->grid);
    for (int kind = 0; kind < RSV_KINDS_OF_LIGHT; kind++) {
        rsv_light_planes *light = &f->light[kind];
        for (int half = 0; half < 2; half++)
            for (int c = 0; c < 3; c++, planes += size) {
                light->half[half][c] = planes;
                light->filtered[half][c] = planes + 6 * size;
            }
        light->variance = planes + 6 * size;
        planes += 7 * size;
    }
    f->variance = planes;
}

static rsv_rgb divisor(rsv_rgb albedo)
{
    return rgb(f_max(albedo.r, LEAST_ALBEDO), f_max(albedo.g, LEAST_ALBEDO),
        f_max(albedo.b, LEAST_ALBEDO));
}

static rsv_rgb light_of(const filter *f, int half, size_t pixel)
{
    const rsv_denoise_half *h = &f->half[half];
    rsv_rgb diffuse = h->diffuse[pixel], by = divisor(h->albedo[pixel]);
    if (f->kind == DIFFUSE) return rgb(diffuse.r / by.r, diffuse.g / by.g, diffuse.b / by.b);
    return rgb_sub(h->picture[pixel], diffuse);
}

static void read_light(const void *user, size_t row)
{
    const filter *f = user;
    const rsv_light_planes *light = &f->light[f->kind];
    for (size_t column = 0; column < f->grid.stride; column++) {
        size_t p = row * f->grid.stride + column, from = rsv_plane_source(&f->grid, column, row);
        rsv_rgb a = light_of(f, 0, from), b = light_of(f, 1, from), apart = rgb_sub(a, b);
        light->half[0][0][p] = a.r;
        light->half[0][1][p] = a.g;
        light->half[0][2][p] = a.b;
        light->half[1][0][p] = b.r;
        light->half[1][1][p] = b.g;
        light->half[1][2][p] = b.b;
        f->variance[p] = 0.5f * (apart.r * apart.r + apart.g * apart.g + apart.b * apart.b);
    }
}

/// Two values say little about a variance: neighbours help.
static void average_variance(const void *user, size_t row)
{
    const filter *f = user;
    ptrdiff_t stride = (ptrdiff_t)f->grid.stride;
    const ptrdiff_t r = VARIANCE_RADIUS;
    if (row < VARIANCE_RADIUS || row + VARIANCE_RADIUS >= f->grid.rows) return;
    for (ptrdiff_t column = r; column + r < stride; column++) {
        const float *at = f->variance + row * f->grid.stride + column;
        float sum = 0;
        for (ptrdiff_t dy = -r; dy <= r; dy++)
            for (ptrdiff_t dx = -r; dx <= r; dx++)
                sum += at[dy * stride + dx];
        f->light[f->kind].variance[row * f->grid.stride + (size_t)column] =
            sum / (float)((2 * r + 1) * (2 * r + 1));
    }
}

/// Variance that counts as none, by the light there is.
static float least_variance(const filter *f)
{
    size_t pixels = (size_t)f->grid.width * f->grid.height;
    double sum = 0;
    for (size_t k = 0; k < pixels; k++)
        sum += (double)rgb_luminance(light_of(f, 0, k));
    double mean = sum / (double)pixels;
    return f_max((float)(NO_VARIANCE * mean * mean), 1e-30f);
}

static rsv_rgb at(float *const plane[3], size_t p)
{
    return rgb(plane[0][p], plane[1][p], plane[2][p]);
}

static void join_lights(const void *user, size_t y)
{
    const filter *f = user;
    const rsv_light_planes *diffuse = &f->light[DIFFUSE], *other = &f->light[OTHER];
    for (size_t x = 0; x < f->grid.width; x++) {
        size_t p = rsv_plane_place(&f->grid, x, y), pixel = y * f->grid.width + x;
        rsv_rgb albedo = rgb_scale(
            rgb_add(divisor(f->half[0].albedo[pixel]), divisor(f->half[1].albedo[pixel])), 0.5f);
        for (int half = 0; half < 2; half++)
            f->filtered[half][pixel] = rgb_add(
                rgb_mul(at(diffuse->filtered[half], p), albedo), at(other->filtered[half], p));
    }
}

static void run(filter *f)
{
    for (f->kind = 0; f->kind < RSV_KINDS_OF_LIGHT; f->kind++) {
        f->light[f->kind].least = least_variance(f);
        rsv_for_plane_rows(&f->grid, f->grid.rows, read_light, f);
        rsv_for_plane_rows(&f->grid, f->grid.rows, average_variance, f);
    }
    rsv_filter_windows(&f->grid, &f->surfaces, f->light, RSV_KINDS_OF_LIGHT);
    rsv_for_plane_rows(&f->grid, f->grid.height, join_lights, f);
}

rsv_status rsv_denoise(rsv_context *context, uint32_t width, uint32_t height,
    const rsv_denoise_half half[2], rsv_rgb *const filtered[2])
{
    if (width == 0 || height == 0) return RSV_OK;
    filter f = {
        .grid = rsv_plane_grid_of(context, width, height), .half = half, .filtered = filtered
    };
    float *planes = rsv_planes_create(&f.grid, ALL_PLANES);
    if (!planes) return RSV_ERROR_MEMORY;
    rsv_find_surfaces(&f.grid, half, planes, &f.surfaces);
    lay_out(&f, planes + SURFACE_PLANES * rsv_plane_size(&f.grid));
    run(&f);
    rsv_free(context, planes);
    return RSV_OK;
}
