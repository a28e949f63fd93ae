/// What the filter leaves of the noise.
#include "../core/core.h"
#include "../render/picture_filter.h"
#include "pixel_error.h"
#include "pixel_window.h"
#include "sample_sum.h"

/// Squared error of a filtered picture of n samples: 1 + BLUR / n times what the difference of its halves shows, because
/// they are filtered by each other, and the filter blurs. Fitted to the hall, the white room and the staircase at 160x90
/// with 2 to 16 samples, beside pictures of 64: estimates are 0.8 to 1.8 times what is found.
#define BLUR 6.0f
/// Two values say little about an error, and the filter spreads the light of a spark: pixels that far on either side,
/// as far as the filter reaches, count too.
#define REACH 5

/// Averages over the pixels around each pixel.
static void average(const float *map, int width, int height, float *mean)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            rsv_pixel_window w = rsv_pixel_window_around(width, height, x, y, REACH);
            float sum = 0, count = (float)((w.right - w.left + 1) * (w.bottom - w.top + 1));
            for (int j = w.top; j <= w.bottom; j++)
                for (int i = w.left; i <= w.right; i++)
                    sum += map[(size_t)j * (size_t)width + (size_t)i];
            mean[(size_t)y * (size_t)width + (size_t)x] = sum / count;
        }
}

/// @param square [pixels] of scratch
static void find_error(const rsv_sample_sum *sum, rsv_image *const filtered[2], float *square)
{
    int width = (int)rsv_image_width(sum->mean), height = (int)rsv_image_height(sum->mean);
    size_t pixels = (size_t)width * (size_t)height;
    for (size_t k = 0; k < pixels; k++)
        square[k] = sum->pixel[k].variance * sum->pixel[k].left;
    average(square, width, height, sum->kept);
    rsv_pixel_squares(sum->mean, filtered[0], filtered[1], square);
    average(square, width, height, sum->filtered_error);
    for (size_t k = 0; k < pixels; k++) {
        float before = sum->kept[k];
        sum->filtered_error[k] *=
            (float)RSV_ERROR_OF_HALVES * (1 + BLUR / (float)sum->pixel[k].taken);
        sum->kept[k] = before > 0 ? sum->filtered_error[k] / before : 0;
    }
}

static rsv_status allocate(rsv_context *context, rsv_sample_sum *sum, size_t pixels)
{
    if (!sum->kept) sum->kept = rsv_alloc(context, pixels, sizeof *sum->kept);
    if (!sum->filtered_error)
        sum->filtered_error = rsv_alloc(context, pixels, sizeof *sum->filtered_error);
    return sum->kept && sum->filtered_error ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_sample_sum_filter(rsv_context *context, rsv_sample_sum *sum, double fall)
{
    if (!sum->side[0] || !sum->side[1]) return RSV_OK;
    size_t pixels = (size_t)rsv_image_width(sum->mean) * rsv_image_height(sum->mean);
    rsv_image *filtered[2];
    float *square = rsv_alloc(context, pixels, sizeof *square);
    rsv_status status = square ? allocate(context, sum, pixels) : RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = rsv_sample_sum_part(context, sum, fall);
    if (status == RSV_OK) status = rsv_picture_filter_halves(context, sum->side, filtered);
    if (status == RSV_OK) {
        find_error(sum, filtered, square);
        rsv_image_destroy(sum->clean);
        sum->clean = rsv_picture_of_halves(filtered);
    }
    rsv_free(context, square);
    return status;
}
