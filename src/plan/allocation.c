#include "allocation.h"

#include "../core/core.h"
#include "pixel_error.h"

#include <math.h>

/// Weights, in a pixel's error, of its eight neighbours, of those in the 5x5 square, and of all pixels. The last two
/// are for sparks, which few neighbours have.
#define NEAR_SHARE 0.6f
#define AROUND_SHARE 0.3f
#define ALL_SHARE 0.1f
/// Camera rays of a pixel at most.
#define MOST_OF_A_PIXEL 16384.0
/// Halvings of the interval that the scale of all numbers lies in.
#define BISECTIONS 30

typedef struct allocator {
    const rsv_sample_sum *sum;
    uint32_t width, height;
    float *own;   ///< [pixels] relative squared errors as found
    float *error; ///< [pixels] by the neighbours: these decide on numbers of samples
    float *worth; ///< [pixels] numbers of samples are proportional to it
    double fall;
} allocator;

/// Sum over the square around a pixel that reaches so far. @param count gets its pixels added
static float sum_around(const allocator *a, uint32_t x, uint32_t y, uint32_t reach, float *count)
{
    float sum = 0;
    for (uint32_t j = y > reach ? y - reach : 0; j <= y + reach && j < a->height; j++) {
        for (uint32_t i = x > reach ? x - reach : 0; i <= x + reach && i < a->width; i++) {
            sum += a->own[(size_t)j * a->width + i];
            ++*count;
        }
    }
    return sum;
}

/// Mean over the square, without the pixel itself.
static float mean_around(const allocator *a, uint32_t x, uint32_t y, uint32_t reach)
{
    float count = 0, sum = sum_around(a, x, y, reach, &count);
    sum -= a->own[(size_t)y * a->width + x];
    return count > 1 ? fmaxf(sum, 0) / (count - 1) : 0;
}

static double mean_of(const float *value, size_t count)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += (double)value[k];
    return sum / (double)count;
}

/// Errors by neighbours, with the same mean as those that were found.
static void find_errors(allocator *a)
{
    size_t pixels = (size_t)a->width * a->height;
    double all = mean_of(a->own, pixels);
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++)
            a->error[(size_t)y * a->width + x] = NEAR_SHARE * mean_around(a, x, y, 1) +
                                                 AROUND_SHARE * mean_around(a, x, y, 2) +
                                                 ALL_SHARE * (float)all;
    double smooth = mean_of(a->error, pixels);
    float scale = smooth > 0 ? (float)(all / smooth) : 0;
    for (size_t k = 0; k < pixels; k++) {
        a->error[k] *= scale;
        a->worth[k] = powf(a->error[k], (float)(1 / (1 + a->fall)));
    }
}

/// Camera rays of a pixel that are there.
static double taken(const allocator *a, size_t pixel)
{
    return a->sum->taken ? a->sum->taken[pixel] : a->sum->samples;
}

static double extra_of(const allocator *a, size_t pixel, double scale)
{
    double wanted = fmin(scale * (double)a->worth[pixel], MOST_OF_A_PIXEL);
    return fmax(floor(wanted - taken(a, pixel) + 0.5), 0);
}

/// Mean number of further rays, and the noise left with them. A pixel's own error does not affect its samples, so its
/// expected decrease is unbiased. Judged by the neighbours, edges would seem to get more samples than they do.
static void look(const allocator *a, double scale, rsv_allocation *found)
{
    size_t pixels = (size_t)a->width * a->height;
    double before = 2 * (double)a->sum->half_samples, rays = 0, noise = 0;
    for (size_t k = 0; k < pixels; k++) {
        double extra = extra_of(a, k, scale);
        rays += extra;
        noise += (double)a->own[k] * pow(before / (taken(a, k) + extra), a->fall);
    }
    found->mean = rays / (double)pixels;
    found->noise = noise / (double)pixels;
}

/// The least scale that reaches the error, or the largest that is not too costly.
static double find_scale(const allocator *a, double error, double most, rsv_allocation *found)
{
    double low = 0, high = 1;
    for (int k = 0; k < 64; k++, low = high, high *= 2) { // at 2^64, all pixels have the most
        look(a, high, found);
        if (found->mean >= most || found->noise <= error) break;
    }
    for (int k = 0; k < BISECTIONS && high > 1.001 * low; k++) {
        double middle = 0.5 * (low + high);
        look(a, middle, found);
        if (found->mean > most || found->noise <= error)
            high = middle;
        else
            low = middle;
    }
    look(a, high, found);
    return found->mean > most ? low : high;
}

static void allocate(allocator *a, double error, double most, rsv_allocation *allocation)
{
    size_t pixels = (size_t)a->width * a->height;
    const rsv_image *const first[2] = { a->sum->half[0], a->sum->half[0] };
    const rsv_image *const second[2] = { a->sum->half[1], a->sum->half[1] };
    const rsv_pixel_error_desc each = { RSV_MOST_OF_A_PIXEL, 0, false };
    rsv_pixel_error_map(first, second, each, a->own);
    for (size_t k = 0; k < pixels; k++)
        a->own[k] *= 0.25f; // of the mean of both
    find_errors(a);
    look(a, 0, allocation);
    double scale = allocation->noise <= error ? 0 : find_scale(a, error, most, allocation);
    look(a, scale, allocation);
    for (size_t k = 0; k < pixels; k++)
        allocation->extra[k] = (uint32_t)extra_of(a, k, scale);
}

rsv_status rsv_allocate_samples(rsv_context *context, const rsv_sample_sum *sum, double fall,
    double error, double most, rsv_allocation *allocation)
{
    allocator a = { .sum = sum,
        .width = rsv_image_width(sum->mean),
        .height = rsv_image_height(sum->mean),
        .fall = fall };
    size_t pixels = (size_t)a.width * a.height;
    rsv_status status = RSV_ERROR_MEMORY;
    *allocation = (rsv_allocation){ 0 };
    allocation->extra = rsv_alloc(context, pixels, sizeof *allocation->extra);
    a.own = rsv_alloc(context, pixels, sizeof *a.own);
    a.error = rsv_alloc(context, pixels, sizeof *a.error);
    a.worth = rsv_alloc(context, pixels, sizeof *a.worth);
    if (allocation->extra && a.own && a.error && a.worth) {
        allocate(&a, error, most, allocation);
        status = RSV_OK;
    }
    rsv_free(context, a.own);
    rsv_free(context, a.error);
    rsv_free(context, a.worth);
    if (status != RSV_OK) rsv_allocation_clear(context, allocation);
    return status;
}

void rsv_allocation_clear(rsv_context *context, rsv_allocation *allocation)
{
    rsv_free(context, allocation->extra);
    *allocation = (rsv_allocation){ 0 };
}
