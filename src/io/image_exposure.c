/// Chooses an exposure for a picture: 0 if its log-average luminance lies in a well-lit range, else just enough to
/// reach the nearer end of that range. So a carefully lit scene keeps its brightness, one in other units becomes
/// visible, and the exposure changes continuously in between.
#include "image_internal.h"

#include <math.h>

#define DARKEST 0.13   ///< of the range, as radiance: 40 % of the codes of sRGB
#define BRIGHTEST 0.36 ///< 63 %
#define DEPTH 8.0      ///< stops below its bright parts beyond which a picture counts as no darker
#define BRIGHT_SHARE 0.05 ///< of the lit pixels, that are bright parts
#define STEPS_PER_STOP 20 ///< what results has two decimals
#define LEAST_LIT 0.0005  ///< of the pixels; fewer say nothing

enum { BINS_PER_STOP = 16, LOWEST_STOP = -150, BINS = (128 - LOWEST_STOP) * BINS_PER_STOP };

/// Logarithm of the luminance to base 2; NAN = black or no number.
static double stops_of(rsv_rgb c)
{
    double luminance = 0.2126 * (double)c.r + 0.7152 * (double)c.g + 0.0722 * (double)c.b;
    return luminance > 0 && isfinite(luminance) ? log2(luminance) : NAN;
}

/// Where the bright parts begin, in stops. @param lit out: pixels that are not black
static double find_bright(const rsv_rgb *pixel, size_t count, size_t *lit)
{
    size_t bin[BINS] = { 0 }, above = 0;
    *lit = 0;
    for (size_t i = 0; i < count; i++) {
        double stops = stops_of(pixel[i]);
        if (isnan(stops)) continue;
        double at = fmin(fmax((stops - LOWEST_STOP) * BINS_PER_STOP, 0), BINS - 1);
        bin[(size_t)at]++;
        ++*lit;
    }
    size_t k = BINS;
    while (k > 0 && (double)above <= BRIGHT_SHARE * (double)*lit)
        above += bin[--k];
    return (double)k / BINS_PER_STOP + LOWEST_STOP;
}

float rsv_image_exposure(const rsv_image *image)
{
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image), lit;
    double floor_stops = find_bright(pixel, count, &lit) - DEPTH, sum = 0;
    if ((double)lit <= LEAST_LIT * (double)count) return 0;
    for (size_t i = 0; i < count; i++) {
        double stops = stops_of(pixel[i]);
        if (!isnan(stops)) sum += fmax(stops, floor_stops);
    }
    double mean = sum / (double)lit;
    double change = fmax(log2(DARKEST) - mean, 0) + fmin(log2(BRIGHTEST) - mean, 0);
    change = fmin(fmax(change, -64), 64);
    return (float)(round(change * STEPS_PER_STOP) / STEPS_PER_STOP);
}
