#include "sample_sum.h"

#include "pixel_error.h"

#include <math.h>

/// Sparks count as much as edges of a bright window do.
#define MOST_OF_A_PIXEL 4

/// mean = (1 - share) mean + share pass, in all layers.
static void mix(rsv_image *mean, const rsv_image *pass, float share)
{
    size_t count = 3 * (size_t)rsv_image_width(mean) * rsv_image_height(mean);
    for (uint32_t layer = 0; layer < rsv_image_layer_count(mean); layer++) {
        float *to = &rsv_image_pixels(mean, layer)->r;
        const float *from = &rsv_image_const_pixels(pass, layer)->r;
        for (size_t k = 0; k < count; k++)
            to[k] += share * (from[k] - to[k]);
    }
}

/// A copy of the first layer.
static rsv_status keep_half(rsv_context *context, rsv_image **half, const rsv_image *pass)
{
    uint32_t width = rsv_image_width(pass), height = rsv_image_height(pass);
    rsv_status status = rsv_image_create(context, width, height, 1, half);
    if (status != RSV_OK) return status;
    const rsv_rgb *from = rsv_image_const_pixels(pass, 0);
    rsv_rgb *to = rsv_image_pixels(*half, 0);
    for (size_t k = 0; k < (size_t)width * height; k++)
        to[k] = from[k];
    return RSV_OK;
}

rsv_status rsv_sample_sum_add(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass)
{
    rsv_status status = RSV_OK;
    if (!sum->half[1]) status = keep_half(context, &sum->half[sum->half[0] ? 1 : 0], pass);
    sum->samples += samples;
    if (!sum->mean) {
        sum->mean = pass;
        sum->half_samples = samples;
        return status;
    }
    mix(sum->mean, pass, (float)samples / (float)sum->samples);
    rsv_image_destroy(pass);
    return status;
}

double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall)
{
    const rsv_image *const first[2] = { sum->half[0], sum->half[0] };
    const rsv_image *const second[2] = { sum->half[1], sum->half[1] };
    const rsv_pixel_error_desc each = { MOST_OF_A_PIXEL, 0, false };
    double uncertainty, square = rsv_pixel_error(first, second, each, &uncertainty);
    double more = (double)sum->samples / (2 * (double)sum->half_samples);
    return 0.25 * square * pow(more, -fall);
}

uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most)
{
    double needed = ceil((double)samples * pow(excess, 1 / fall));
    return needed <= 1 ? 1 : needed < (double)most ? (uint32_t)needed : most;
}

void rsv_sample_sum_clear(rsv_sample_sum *sum)
{
    rsv_image_destroy(sum->mean);
    rsv_image_destroy(sum->half[0]);
    rsv_image_destroy(sum->half[1]);
    *sum = (rsv_sample_sum){ 0 };
}
