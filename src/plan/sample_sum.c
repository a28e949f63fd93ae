#include "sample_sum.h"

#include "../core/core.h"
#include "../core/vec.h"
#include "pixel_error.h"

#include <math.h>

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

rsv_status rsv_sample_sum_add_pair(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass[2])
{
    RSV_ASSERT(!sum->taken);
    if (sum->half[1]) {
        sum->half_samples += samples;
        for (int k = 0; k < 2; k++)
            mix(sum->half[k], pass[k], (float)samples / (float)sum->half_samples);
    }
    rsv_status first = rsv_sample_sum_add(context, sum, samples, pass[0]);
    rsv_status second = rsv_sample_sum_add(context, sum, samples, pass[1]);
    return first != RSV_OK ? first : second;
}

/// Each pixel by the samples that it has.
static void mix_uneven(const rsv_sample_sum *sum, const uint32_t *count, const rsv_image *pass)
{
    size_t pixels = (size_t)rsv_image_width(pass) * rsv_image_height(pass);
    for (uint32_t layer = 0; layer < rsv_image_layer_count(pass); layer++) {
        rsv_rgb *to = rsv_image_pixels(sum->mean, layer);
        const rsv_rgb *from = rsv_image_const_pixels(pass, layer);
        for (size_t k = 0; k < pixels; k++) {
            if (count[k] == 0) continue;
            float share = (float)count[k] / (float)(sum->taken[k] + count[k]);
            to[k] = rgb_mad(to[k], share, rgb_sub(from[k], to[k]));
        }
    }
}

rsv_status rsv_sample_sum_add_uneven(
    rsv_context *context, rsv_sample_sum *sum, const uint32_t *count, rsv_image *pass)
{
    size_t pixels = (size_t)rsv_image_width(pass) * rsv_image_height(pass);
    uint64_t all = 0;
    if (!sum->taken) {
        sum->taken = rsv_alloc(context, pixels, sizeof *sum->taken);
        for (size_t k = 0; sum->taken && k < pixels; k++)
            sum->taken[k] = sum->samples;
    }
    if (sum->taken) {
        mix_uneven(sum, count, pass);
        for (size_t k = 0; k < pixels; k++)
            all += sum->taken[k] += count[k];
        sum->samples = (uint32_t)((all + pixels / 2) / pixels);
    }
    rsv_image_destroy(pass);
    return sum->taken ? RSV_OK : RSV_ERROR_MEMORY;
}

double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall)
{
    const rsv_image *const first[2] = { sum->half[0], sum->half[0] };
    const rsv_image *const second[2] = { sum->half[1], sum->half[1] };
    const rsv_pixel_error_desc each = { RSV_MOST_OF_A_PIXEL, 0, false };
    double uncertainty, square = rsv_pixel_error(first, second, each, &uncertainty);
    double more = (double)sum->samples / (2 * (double)sum->half_samples);
    return 0.25 * square * pow(more, -fall);
}

uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most)
{
    double needed = ceil((double)samples * pow(excess, 1 / fall));
    return needed <= 1 ? 1 : needed < (double)most ? (uint32_t)needed : most;
}

void rsv_sample_sum_clear(rsv_context *context, rsv_sample_sum *sum)
{
    rsv_free(context, sum->taken);
    rsv_image_destroy(sum->mean);
    rsv_image_destroy(sum->half[0]);
    rsv_image_destroy(sum->half[1]);
    *sum = (rsv_sample_sum){ 0 };
}
