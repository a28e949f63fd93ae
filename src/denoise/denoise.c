#include "denoise.h"

#include "denoise_constants.h"
#include "mixture.h"
#include "surfaces.h"
#include "window.h"

#define LIGHT_PLANES 8
#define FILTERED_PLANES (6 * RSV_MEAN_KINDS)
#define MIXED_PLANES 3
#define ALL_PLANES (SURFACE_PLANES + LIGHT_PLANES + FILTERED_PLANES + MIXED_PLANES + MIXTURE_PLANES)

typedef struct filter {
    rsv_plane_grid grid;
    const rsv_denoise_half *half;
    rsv_surface_planes surfaces;
    rsv_light_planes light;
    float *raw_variance; ///< [plane] of one half, from this pixel alone
    rsv_filtered_planes filtered;
    float *mixed[3];
    float *work; ///< [MIXTURE_PLANES]
    bool diffuse; ///< which light is filtered
    rsv_rgb *picture;
} filter;

static float *next_plane(filter *f, float **planes)
{
    float *plane = *planes;
    *planes += rsv_plane_size(&f->grid);
    return plane;
}

static void lay_out(filter *f, float *planes)
{
    for (int k = 0; k < 6; k++)
        f->light.half[k / 3][k % 3] = next_plane(f, &planes);
    f->light.variance = next_plane(f, &planes);
    f->raw_variance = next_plane(f, &planes);
    for (int kind = 0; kind < RSV_MEAN_KINDS; kind++)
        for (int k = 0; k < 6; k++)
            f->filtered.half[kind][k / 3][k % 3] = next_plane(f, &planes);
    for (int c = 0; c < 3; c++)
        f->mixed[c] = next_plane(f, &planes);
    f->work = planes;
}

static rsv_rgb safe_albedo(rsv_rgb albedo)
{
    return rgb(f_max(albedo.r, LEAST_ALBEDO), f_max(albedo.g, LEAST_ALBEDO),
        f_max(albedo.b, LEAST_ALBEDO));
}

static rsv_rgb divided(rsv_rgb a, rsv_rgb b) { return rgb(a.r / b.r, a.g / b.g, a.b / b.b); }

/// The light of a pixel that is being filtered.
static rsv_rgb light_of(const filter *f, int half, size_t pixel)
{
    const rsv_denoise_half *h = &f->half[half];
    if (f->diffuse) return divided(h->diffuse[pixel], safe_albedo(h->albedo[pixel]));
    return rgb_sub(h->picture[pixel], h->diffuse[pixel]);
}

static void read_light(const void *user, size_t row)
{
    const filter *f = user;
    for (size_t column = 0; column < f->grid.stride; column++) {
        size_t p = row * f->grid.stride + column, from = rsv_plane_source(&f->grid, column, row);
        float variance = 0;
        for (int half = 0; half < 2; half++) {
            rsv_rgb light = light_of(f, half, from);
            f->light.half[half][0][p] = light.r;
            f->light.half[half][1][p] = light.g;
            f->light.half[half][2][p] = light.b;
        }
        for (int c = 0; c < 3; c++) {
            float apart = f->light.half[0][c][p] - f->light.half[1][c][p];
            variance += 0.5f * apart * apart;
        }
        f->raw_variance[p] = variance;
    }
}

static void average_variance(const void *user, size_t row)
{
    const filter *f = user;
    ptrdiff_t stride = (ptrdiff_t)f->grid.stride;
    if (row < VARIANCE_RADIUS || row + VARIANCE_RADIUS >= f->grid.rows) return;
    for (ptrdiff_t column = VARIANCE_RADIUS; column + VARIANCE_RADIUS < stride; column++) {
        size_t p = row * f->grid.stride + (size_t)column;
        float sum = 0;
        for (ptrdiff_t dy = -VARIANCE_RADIUS; dy <= VARIANCE_RADIUS; dy++)
            for (ptrdiff_t dx = -VARIANCE_RADIUS; dx <= VARIANCE_RADIUS; dx++)
                sum += (f->raw_variance + p)[dy * stride + dx];
        f->light.variance[p] = sum / ((2 * VARIANCE_RADIUS + 1) * (2 * VARIANCE_RADIUS + 1));
    }
}

static void add_to_picture(const void *user, size_t y)
{
    const filter *f = user;
    for (size_t x = 0; x < f->grid.width; x++) {
        size_t p = rsv_plane_place(&f->grid, x, y), pixel = y * f->grid.width + x;
        rsv_rgb light = rgb(f->mixed[0][p], f->mixed[1][p], f->mixed[2][p]);
        if (f->diffuse)
            f->picture[pixel] =
                rgb_mul(light, rgb_scale(rgb_add(safe_albedo(f->half[0].albedo[pixel]),
                                             safe_albedo(f->half[1].albedo[pixel])),
                                   0.5f));
        else
            f->picture[pixel] = rgb_positive(rgb_add(f->picture[pixel], light));
    }
}

/// Square of the mean light of what is filtered.
static float mean_square(const filter *f)
{
    size_t pixels = (size_t)f->grid.width * f->grid.height;
    double sum = 0;
    for (size_t k = 0; k < pixels; k++)
        sum += (double)rgb_luminance(light_of(f, 0, k));
    return (float)(sum * sum / ((double)pixels * (double)pixels));
}

static void filter_light(filter *f, bool diffuse)
{
    f->diffuse = diffuse;
    float least = f_max(NO_VARIANCE * mean_square(f), 1e-30f);
    rsv_for_plane_rows(&f->grid, f->grid.rows, read_light, f);
    rsv_for_plane_rows(&f->grid, f->grid.rows, average_variance, f);
    rsv_filter_windows(&f->grid, &f->surfaces, &f->light, least, &f->filtered);
    rsv_mix_by_errors(&f->grid, &f->light, &f->filtered, least, f->work, f->mixed);
    rsv_for_plane_rows(&f->grid, f->grid.height, add_to_picture, f);
}

rsv_status rsv_denoise(rsv_context *context, uint32_t width, uint32_t height,
    const rsv_denoise_half half[2], rsv_rgb *picture)
{
    if (width == 0 || height == 0) return RSV_OK;
    filter f = { .grid = rsv_plane_grid_of(context, width, height), .half = half, .picture = picture };
    float *planes = rsv_planes_create(&f.grid, ALL_PLANES);
    if (!planes) return RSV_ERROR_MEMORY;
    rsv_find_surfaces(&f.grid, half, planes, &f.surfaces);
    lay_out(&f, planes + SURFACE_PLANES * rsv_plane_size(&f.grid));
    filter_light(&f, true);
    filter_light(&f, false);
    rsv_free(context, planes);
    return RSV_OK;
}
