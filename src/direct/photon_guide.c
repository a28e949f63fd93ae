#include "photon_guide.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "direct_constants.h"

/// Cumulative sums of a row or column of weights, normalised; returns the sum.
static float accumulate(const float *weight, float *cdf, int count)
{
    float sum = 0;
    for (int k = 0; k < count; k++)
        cdf[k] = sum += weight[k];
    for (int k = 0; k < count; k++)
        cdf[k] = sum > 0 ? cdf[k] / sum : (float)(k + 1) / (float)count;
    return sum;
}

static float bin_area(const rsv_guide_grid *grid, int bin)
{
    int row = bin / RSV_GUIDE_SIDE, column = bin % RSV_GUIDE_SIDE;
    return (grid->x[column + 1] - grid->x[column]) * (grid->y[row + 1] - grid->y[row]);
}

static void tabulate(rsv_photon_guide *guide, const float *useful)
{
    const int bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
    float row_sum[RSV_GUIDE_SIDE], mass[RSV_GUIDE_SIDE], total = 0;
    for (int k = 0; k < bins; k++)
        total += useful[k] * bin_area(&guide->grid, k);
    guide->useful = total / RSV_GUIDE_RAYS;
    for (int k = 0; k < bins; k++) {
        float even = 1 / (bin_area(&guide->grid, k) * (float)bins);
        float guided = total > 0 ? useful[k] / total : even;
        guide->density[k] =
            GUIDED_SHARE * guided + EVEN_SHARE * even + (1 - GUIDED_SHARE - EVEN_SHARE);
    }
    for (int row = 0; row < RSV_GUIDE_SIDE; row++) {
        int first = row * RSV_GUIDE_SIDE;
        for (int k = 0; k < RSV_GUIDE_SIDE; k++)
            mass[k] = guide->density[first + k] * bin_area(&guide->grid, first + k);
        row_sum[row] = accumulate(mass, guide->cell_cdf + first, RSV_GUIDE_SIDE);
    }
    accumulate(row_sum, guide->row_cdf, RSV_GUIDE_SIDE);
}

// ---- grid ---------------------------------------------------------------------------------------

rsv_guide_grid rsv_guide_grid_even(void)
{
    rsv_guide_grid grid;
    for (int k = 0; k <= RSV_GUIDE_SIDE; k++)
        grid.x[k] = grid.y[k] = (float)k / RSV_GUIDE_SIDE;
    return grid;
}

/// Lines that hold all but the outermost parts of a weight between them, with one bin to spare.
static void enclose(const float *weight, int *low, int *high)
{
    float cdf[RSV_GUIDE_SIDE];
    accumulate(weight, cdf, RSV_GUIDE_SIDE);
    for (*low = 0; *low < RSV_GUIDE_SIDE - 1 && cdf[*low] < OUTSIDE; ++*low) {}
    for (*high = RSV_GUIDE_SIDE - 1; *high > *low && cdf[*high - 1] > 1 - OUTSIDE; --*high) {}
    *low = *low > 0 ? *low - 1 : 0;
    *high = *high < RSV_GUIDE_SIDE - 1 ? *high + 2 : RSV_GUIDE_SIDE;
}

/// Lines evenly from line `low` to line `high` of before, and a few outside.
static void draw_together(float *line, int low, int high)
{
    float begin = line[low], end = line[high];
    int before = begin > 0 ? OUTER_BINS : 0, after = end < 1 ? OUTER_BINS : 0;
    int inner = RSV_GUIDE_SIDE - before - after;
    for (int k = 0; k <= before; k++)
        line[k] = before ? begin * (float)k / (float)before : begin;
    for (int k = 0; k <= inner; k++)
        line[before + k] = begin + (end - begin) * (float)k / (float)inner;
    for (int k = 1; k <= after; k++)
        line[before + inner + k] = end + (1 - end) * (float)k / (float)after;
    line[RSV_GUIDE_SIDE] = 1;
}

bool rsv_guide_grid_zoom(rsv_guide_grid *grid, const float *useful)
{
    float column[RSV_GUIDE_SIDE] = { 0 }, row[RSV_GUIDE_SIDE] = { 0 }, total = 0;
    for (int k = 0; k < RSV_GUIDE_SIDE * RSV_GUIDE_SIDE; k++) {
        float worth = useful[k] * bin_area(grid, k);
        column[k % RSV_GUIDE_SIDE] += worth;
        row[k / RSV_GUIDE_SIDE] += worth;
        total += worth;
    }
    if (!(total > 0)) return false;
    int left, right, top, bottom;
    enclose(column, &left, &right);
    enclose(row, &top, &bottom);
    if ((right - left) * (bottom - top) > RSV_GUIDE_SIDE * RSV_GUIDE_SIDE / 4) return false;
    draw_together(grid->x, left, right);
    draw_together(grid->y, top, bottom);
    return true;
}

/// Spreads part of each bin's weight to its neighbours, because the few pilot rays may have missed the rim of an
/// object.
static void blur(const float *in, float *out)
{
    for (int y = 0; y < RSV_GUIDE_SIDE; y++) {
        for (int x = 0; x < RSV_GUIDE_SIDE; x++) {
            float sum = in[y * RSV_GUIDE_SIDE + x];
            for (int n = 0; n < 9; n++) {
                int nx = x + n % 3 - 1, ny = y + n / 3 - 1;
                if (nx < 0 || ny < 0 || nx >= RSV_GUIDE_SIDE || ny >= RSV_GUIDE_SIDE) continue;
                sum += 0.25f * in[ny * RSV_GUIDE_SIDE + nx];
            }
            out[y * RSV_GUIDE_SIDE + x] = sum;
        }
    }
}

rsv_status rsv_photon_guide_create(
    rsv_context *context, const rsv_guide_grid *grid, const float *useful, rsv_photon_guide *guide)
{
    const size_t bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
    guide->grid = *grid;
    guide->row_cdf = rsv_alloc(context, RSV_GUIDE_SIDE, sizeof(float));
    guide->cell_cdf = rsv_alloc(context, bins, sizeof(float));
    guide->density = rsv_alloc(context, bins, sizeof(float));
    float *blurred = rsv_alloc(context, bins, sizeof *blurred);
    bool allocated = guide->row_cdf && guide->cell_cdf && guide->density && blurred;
    if (allocated) {
        blur(useful, blurred);
        tabulate(guide, blurred);
    }
    rsv_free(context, blurred);
    return allocated ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_photon_guide_destroy(rsv_context *context, rsv_photon_guide *guide)
{
    rsv_free(context, guide->row_cdf);
    rsv_free(context, guide->cell_cdf);
    rsv_free(context, guide->density);
}
