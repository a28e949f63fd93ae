/// Marginal and conditional distributions over the cells of a latitude-longitude picture.
#include "../core/core.h"
#include "sky.h"

#define MAX_COLUMNS 2048 ///< cells along the equator; larger pictures have several pixels in each

/// Luminance of the interpolated picture, on average over one row of pixels.
static void average_row(const rsv_sky *sky, uint32_t row, const float *tent, float *luminance)
{
    uint32_t above = row ? row - 1 : 0, below = row + 1 < sky->height ? row + 1 : row;
    const uint32_t rows[3] = { above, row, below };
    for (uint32_t x = 0; x < sky->width; x++) {
        luminance[x] = 0;
        for (int k = 0; k < 3; k++)
            luminance[x] += tent[k] * rgb_luminance(sky->pixel[(size_t)rows[k] * sky->width + x]);
    }
}

/// Adds the flux of one row of pixels to its cells.
static void add_row(rsv_sky_sampler *s, uint32_t row, float *luminance)
{
    // integral of linear interpolation, over a pixel's own area, of it and its neighbours
    static const float tent[3] = { 0.125f, 0.75f, 0.125f };
    const rsv_sky *sky = &s->sky;
    average_row(sky, row, tent, luminance);
    float solid_angle = (float)rsv_sky_pixel_solid_angle(sky, row);
    float *cell = s->cell_cdf + (size_t)(row / s->stride) * s->columns;
    for (uint32_t x = 0; x < sky->width; x++) {
        float left = luminance[x ? x - 1 : sky->width - 1];
        float right = luminance[x + 1 < sky->width ? x + 1 : 0];
        float mean = tent[0] * left + tent[1] * luminance[x] + tent[2] * right;
        cell[x / s->stride] += mean * solid_angle;
    }
}

/// Turns fluxes into densities and cumulative sums.
static void finish(rsv_sky_sampler *s)
{
    double total = 0;
    for (uint32_t row = 0; row < s->rows; row++) {
        float *cell = s->cell_cdf + (size_t)row * s->columns;
        float *density = s->density + (size_t)row * s->columns;
        double sum = 0, upper, lower, left, width;
        rsv_sky_row_edges(s, row, &upper, &lower);
        for (uint32_t c = 0; c < s->columns; c++) {
            rsv_sky_column_edges(s, c, &left, &width);
            density[c] = (float)(cell[c] / (2 * M_PI * width * (upper - lower)));
            sum += cell[c];
            cell[c] = (float)sum;
        }
        for (uint32_t c = 0; c < s->columns && sum > 0; c++)
            cell[c] = (float)(cell[c] / sum);
        total += sum;
        s->row_cdf[row] = (float)total;
    }
    for (uint32_t row = 0; row < s->rows && total > 0; row++)
        s->row_cdf[row] = (float)(s->row_cdf[row] / total);
    for (size_t k = 0; k < (size_t)s->rows * s->columns && total > 0; k++)
        s->density[k] = (float)(s->density[k] / total);
    s->flux = total;
}

rsv_status rsv_sky_sampler_create(
    rsv_context *context, const rsv_sky *sky, rsv_sky_sampler *sampler)
{
    *sampler = (rsv_sky_sampler){ .sky = *sky };
    if (!sky->pixel) return RSV_OK;
    sampler->stride = (sky->width + MAX_COLUMNS - 1) / MAX_COLUMNS;
    sampler->columns = (sky->width + sampler->stride - 1) / sampler->stride;
    sampler->rows = (sky->height + sampler->stride - 1) / sampler->stride;
    size_t cells = (size_t)sampler->rows * sampler->columns;
    sampler->row_cdf = rsv_alloc(context, sampler->rows, sizeof *sampler->row_cdf);
    sampler->cell_cdf = rsv_alloc(context, cells, sizeof *sampler->cell_cdf);
    sampler->density = rsv_alloc(context, cells, sizeof *sampler->density);
    float *luminance = rsv_alloc(context, sky->width, sizeof *luminance);
    bool complete = sampler->row_cdf && sampler->cell_cdf && sampler->density && luminance;
    for (uint32_t row = 0; complete && row < sky->height; row++)
        add_row(sampler, row, luminance);
    if (complete) finish(sampler);
    rsv_free(context, luminance);
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_sky_sampler_destroy(rsv_context *context, rsv_sky_sampler *sampler)
{
    rsv_free(context, sampler->row_cdf);
    rsv_free(context, sampler->cell_cdf);
    rsv_free(context, sampler->density);
    *sampler = (rsv_sky_sampler){ 0 };
}
