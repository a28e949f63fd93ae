#include "../core/vec.h"
#include "image_internal.h"

#include <stdlib.h>

static size_t pixel_count(const rsv_image *image)
{
    return (size_t)rsv_image_width(image) * rsv_image_height(image);
}

static double luminance(rsv_rgb c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

static rsv_status check_layer(const rsv_image *image, uint32_t layer, const char *which)
{
    if (layer >= rsv_image_layer_count(image))
        return rsv_fail(RSV_ERROR_ARGUMENT, "compare: %s has %u layers, no layer %u", which,
            rsv_image_layer_count(image), layer);
    const rsv_rgb *pixels = rsv_image_const_pixels(image, layer);
    uint32_t width = rsv_image_width(image);
    for (size_t i = 0; i < pixel_count(image); i++)
        if (!isfinite(pixels[i].r) || !isfinite(pixels[i].g) || !isfinite(pixels[i].b))
            return rsv_fail(RSV_ERROR_FORMAT,
                "compare: %s, layer '%s', has a value that is not finite at pixel (%zu, %zu)",
                which, rsv_image_layer_name(image, layer), i % width, i / width);
    return RSV_OK;
}

rsv_status rsv_image_check_pair(
    const rsv_image *a, uint32_t layer_a, const rsv_image *b, uint32_t layer_b)
{
    if (rsv_image_width(a) != rsv_image_width(b) || rsv_image_height(a) != rsv_image_height(b))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "compare: the reference has %u x %u pixels, the other picture %u x %u",
            rsv_image_width(a), rsv_image_height(a), rsv_image_width(b), rsv_image_height(b));
    rsv_status status = check_layer(a, layer_a, "the reference");
    return status == RSV_OK ? check_layer(b, layer_b, "the other picture") : status;
}

/// Black against black is equal.
static double ratio(double numerator, double denominator)
{
    return numerator == 0 && denominator == 0 ? 1 : numerator / denominator;
}

static void compare_means(const rsv_rgb *a, const rsv_rgb *b, size_t count,
    rsv_image_difference *difference, double *mean_a)
{
    double sum_a[3] = { 0 }, sum_b[3] = { 0 };
    for (size_t i = 0; i < count; i++) {
        sum_a[0] += a[i].r, sum_a[1] += a[i].g, sum_a[2] += a[i].b;
        sum_b[0] += b[i].r, sum_b[1] += b[i].g, sum_b[2] += b[i].b;
    }
    for (int c = 0; c < 3; c++)
        difference->channel_mean_ratio[c] = ratio(sum_b[c], sum_a[c]);
    difference->mean_ratio = ratio(sum_b[0] + sum_b[1] + sum_b[2], sum_a[0] + sum_a[1] + sum_a[2]);
    *mean_a = (sum_a[0] + sum_a[1] + sum_a[2]) / (3.0 * (double)count);
}

static void compare_squares(const rsv_rgb *a, const rsv_rgb *b, size_t count, double mean_a,
    rsv_image_difference *difference)
{
    double squares = 0, relative_squares = 0, peak = 0;
    for (size_t i = 0; i < count; i++) {
        const double va[3] = { a[i].r, a[i].g, a[i].b }, vb[3] = { b[i].r, b[i].g, b[i].b };
        for (int c = 0; c < 3; c++) {
            double square = (vb[c] - va[c]) * (vb[c] - va[c]);
            squares += square;
            if (square > 0) relative_squares += square / (va[c] * va[c] + 0.01 * mean_a * mean_a);
            peak = fmax(peak, va[c]);
        }
    }
    double values = 3.0 * (double)count;
    difference->rmse = sqrt(squares / values);
    difference->relative_mse = relative_squares / values;
    difference->psnr = squares > 0 ? 20 * log10(peak / difference->rmse) : INFINITY;
}

static int compare_floats(const void *left, const void *right)
{
    float l = *(const float *)left, r = *(const float *)right;
    return (l > r) - (l < r);
}

static double median(float *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_floats);
    return 0.5 * ((double)values[(count - 1) / 2] + (double)values[count / 2]);
}

static rsv_status compare_luminance(rsv_context *context, const rsv_rgb *a, const rsv_rgb *b,
    size_t count, rsv_image_difference *difference)
{
    float *errors = rsv_alloc(context, count, sizeof *errors);
    if (!errors) return RSV_ERROR_MEMORY;
    double mean = 0;
    for (size_t i = 0; i < count; i++)
        mean += luminance(a[i]) / (double)count;
    for (size_t i = 0; i < count; i++) {
        double error = fabs(luminance(b[i]) - luminance(a[i]));
        errors[i] = error > 0 ? (float)(error / fmax(luminance(a[i]), 1e-3 * mean)) : 0;
    }
    difference->median_relative_error = median(errors, count);
    rsv_free(context, errors);
    return RSV_OK;
}

rsv_status rsv_image_compare(const rsv_image *a, uint32_t layer_a, const rsv_image *b,
    uint32_t layer_b, rsv_image_difference *difference)
{
    rsv_status status = rsv_image_check_pair(a, layer_a, b, layer_b);
    if (status != RSV_OK) return status;
    const rsv_rgb *pixels_a = rsv_image_const_pixels(a, layer_a);
    const rsv_rgb *pixels_b = rsv_image_const_pixels(b, layer_b);
    double mean_a;
    compare_means(pixels_a, pixels_b, pixel_count(a), difference, &mean_a);
    compare_squares(pixels_a, pixels_b, pixel_count(a), mean_a, difference);
    return compare_luminance(rsv_image_context(a), pixels_a, pixels_b, pixel_count(a), difference);
}
