#include "photon_guide.h"

#include "../core/vec.h"

#define GUIDED_SHARE 0.9f ///< the rest goes everywhere alike, as the source would by itself

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

static void tabulate(rsv_photon_guide *guide, const float *useful)
{
    const int bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
    float row_sum[RSV_GUIDE_SIDE], total = 0;
    for (int k = 0; k < bins; k++)
        total += useful[k];
    guide->useful = total / ((float)bins * RSV_GUIDE_RAYS);
    for (int k = 0; k < bins; k++)
        guide->density[k] =
            total > 0 ? GUIDED_SHARE * useful[k] * (float)bins / total + (1 - GUIDED_SHARE) : 1;
    for (int row = 0; row < RSV_GUIDE_SIDE; row++) {
        int first = row * RSV_GUIDE_SIDE;
        row_sum[row] = accumulate(guide->density + first, guide->cell_cdf + first, RSV_GUIDE_SIDE);
    }
    accumulate(row_sum, guide->row_cdf, RSV_GUIDE_SIDE);
}

/// Neighbouring bins get part of a bin's weight: what the few pilot rays missed at an object's rim.
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
    rsv_context *context, const float *useful, rsv_photon_guide *guide)
{
    const size_t bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
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

/// Entry of a cumulative table that holds x, which becomes its place within it.
static int invert(const float *cdf, int count, float *x)
{
    int k = 0, last = count - 1;
    while (k < last) {
        int middle = (k + last) / 2;
        if (*x < cdf[middle])
            last = middle;
        else
            k = middle + 1;
    }
    float low = k ? cdf[k - 1] : 0, width = cdf[k] - low;
    *x = width > 0 ? f_min((*x - low) / width, 0x1.fffffep-1f) : 0.5f;
    return k;
}

float rsv_photon_guide_warp(const rsv_photon_guide *guide, float *x, float *y)
{
    int row = invert(guide->row_cdf, RSV_GUIDE_SIDE, y);
    int column = invert(guide->cell_cdf + row * RSV_GUIDE_SIDE, RSV_GUIDE_SIDE, x);
    *x = f_min(((float)column + *x) / RSV_GUIDE_SIDE, 0x1.fffffep-1f);
    *y = f_min(((float)row + *y) / RSV_GUIDE_SIDE, 0x1.fffffep-1f);
    return guide->density[row * RSV_GUIDE_SIDE + column];
}
