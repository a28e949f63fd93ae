#include "allocation.h"

#include "../core/core.h"

#include <math.h>

/// Weights, in a pixel's error, of its eight neighbours, of those in the 5x5 square, and of all pixels. The last two
/// are for sparks, which few neighbours have.
#define NEAR_SHARE 0.6f
#define AROUND_SHARE 0.3f
#define ALL_SHARE 0.1f
/// A pixel counts no more than this in the last one: a spark says little about pixels far from it.
#define MOST_FOR_ALL 4.0f
/// A spark has at least this relative squared error, and this many times that of the 5x5 square.
#define SPARK 4.0f
#define SPARK_EXCESS 4.0f
/// Camera rays of a pixel at most, and of a spark at least.
#define MOST_OF_A_PIXEL 16384.0
#define LEAST_OF_A_SPARK 8.0
/// Halvings of the interval that the scale of all numbers lies in.
#define BISECTIONS 30

typedef struct allocator {
    const rsv_sample_sum *sum;
    uint32_t width, height;
    float *own;     ///< [pixels] relative squared error of one sample, as found
    float *renewed; ///< [pixels] the same by the neighbours, for sparks; 0 = no spark
    float *worth;   ///< [pixels] numbers of samples are proportional to it
    double fall;
    const uint8_t *is_outline; ///< as in the sum; NULL = none
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

/// Mean over all pixels, sparks limited.
static float mean_of_all(const allocator *a)
{
    size_t pixels = (size_t)a->width * a->height;
    double sum = 0;
    for (size_t k = 0; k < pixels; k++)
        sum += (double)fminf(a->own[k], MOST_FOR_ALL / a->sum->pixel[k].left);
    return (float)(sum / (double)pixels);
}

static bool is_spark(const allocator *a, size_t pixel, float around)
{
    float left = a->sum->pixel[pixel].left, error = a->own[pixel] * left;
    return error > SPARK && error > SPARK_EXCESS * around * left;
}

/// What a pixel's samples are worth by the errors around it, and for sparks by their own.
static void find_worth(allocator *a, uint32_t x, uint32_t y, float all)
{
    size_t pixel = (size_t)y * a->width + x;
    float around = mean_around(a, x, y, 2);
    float error = NEAR_SHARE * mean_around(a, x, y, 1) + AROUND_SHARE * around + ALL_SHARE * all;
    a->renewed[pixel] = 0;
    if (is_spark(a, pixel, around)) {
        a->renewed[pixel] = fmaxf(error, 1e-20f);
        error = a->own[pixel];
    }
    a->worth[pixel] = powf(error, (float)(1 / (1 + a->fall)));
}

/// Relative squared error of one sample; with a filter, what it leaves of it.
static float variance_of(const rsv_sample_sum *sum, size_t pixel)
{
    return sum->pixel[pixel].variance * (sum->kept ? sum->kept[pixel] : 1);
}

static void find_errors(allocator *a)
{
    float all;
    for (size_t k = 0; k < (size_t)a->width * a->height; k++)
        a->own[k] = variance_of(a->sum, k);
    all = mean_of_all(a);
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++)
            find_worth(a, x, y, all);
}

static double extra_of(const allocator *a, size_t pixel, double scale)
{
    double wanted = fmin(scale * (double)a->worth[pixel], MOST_OF_A_PIXEL);
    if (a->is_outline && a->is_outline[pixel]) wanted = fmax(wanted, RSV_OUTLINE_SAMPLES);
    if (a->renewed[pixel] > 0) return fmax(floor(wanted + 0.5), LEAST_OF_A_SPARK);
    return fmax(floor(wanted - a->sum->pixel[pixel].taken + 0.5), 0);
}

/// Mean number of further rays, and the noise left with them. A pixel's own error does not affect its samples, so its
/// expected decrease is unbiased. Judged by the neighbours, edges would seem to get more samples than they do.
static void look(const allocator *a, double scale, rsv_allocation *found)
{
    size_t pixels = (size_t)a->width * a->height;
    double rays = 0, noise = 0;
    for (size_t k = 0; k < pixels; k++) {
        double extra = extra_of(a, k, scale);
        bool renewed = a->renewed[k] > 0;
        double variance = (double)(renewed ? a->renewed[k] : a->own[k]);
        rays += extra;
        noise += variance * rsv_variance_left(&a->sum->pixel[k], extra, renewed, a->fall);
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

/// With too few rays even for sparks and outlines, these stay: the rays are for all pixels.
static void keep_sparks(allocator *a)
{
    a->is_outline = NULL;
    for (size_t k = 0; k < (size_t)a->width * a->height; k++)
        a->renewed[k] = 0;
}

static void allocate(allocator *a, double error, double most, rsv_allocation *allocation)
{
    size_t pixels = (size_t)a->width * a->height;
    find_errors(a);
    look(a, 0, allocation);
    if (allocation->mean > most) {
        keep_sparks(a);
        look(a, 0, allocation);
    }
    double scale = allocation->noise <= error ? 0 : find_scale(a, error, most, allocation);
    look(a, scale, allocation);
    for (size_t k = 0; k < pixels; k++)
        allocation->extra[k] = (uint32_t)extra_of(a, k, scale);
}

rsv_status rsv_allocate_samples(rsv_context *context, rsv_sample_sum *sum, double fall,
    double error, double most, rsv_allocation *allocation)
{
    allocator a = { .sum = sum,
        .width = rsv_image_width(sum->mean),
        .height = rsv_image_height(sum->mean),
        .fall = fall,
        .is_outline = sum->is_outline };
    size_t pixels = (size_t)a.width * a.height;
    *allocation = (rsv_allocation){ .fall = fall };
    rsv_status status = rsv_sample_sum_part(context, sum, fall);
    allocation->extra = rsv_alloc(context, pixels, sizeof *allocation->extra);
    a.renewed = allocation->renewed = rsv_alloc(context, pixels, sizeof *a.renewed);
    a.own = rsv_alloc(context, pixels, sizeof *a.own);
    a.worth = rsv_alloc(context, pixels, sizeof *a.worth);
    if (!allocation->extra || !a.own || !a.renewed || !a.worth) status = RSV_ERROR_MEMORY;
    if (status == RSV_OK) allocate(&a, error, most, allocation);
    rsv_free(context, a.own);
    rsv_free(context, a.worth);
    if (status != RSV_OK) rsv_allocation_clear(context, allocation);
    return status;
}

double rsv_uneven_noise(const rsv_sample_sum *sum)
{
    size_t pixels = (size_t)rsv_image_width(sum->mean) * rsv_image_height(sum->mean);
    double noise = 0;
    for (size_t k = 0; k < pixels; k++)
        noise += sum->filtered_error ? (double)sum->filtered_error[k]
                                     : (double)sum->pixel[k].variance * (double)sum->pixel[k].left;
    return noise / (double)pixels;
}

void rsv_allocation_clear(rsv_context *context, rsv_allocation *allocation)
{
    rsv_free(context, allocation->extra);
    rsv_free(context, allocation->renewed);
    *allocation = (rsv_allocation){ 0 };
}
