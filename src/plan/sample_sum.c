#include "sample_sum.h"

#include "../core/core.h"
#include "../core/vec.h"
#include "../render/picture_filter.h"
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

/// A copy of the first layers.
static rsv_status copy_layers(
    rsv_context *context, const rsv_image *image, uint32_t count, rsv_image **copy)
{
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    rsv_status status = rsv_image_create(context, width, height, count, copy);
    for (uint32_t layer = 0; layer < count && status == RSV_OK; layer++) {
        const rsv_rgb *from = rsv_image_const_pixels(image, layer);
        rsv_rgb *to = rsv_image_pixels(*copy, layer);
        for (size_t k = 0; k < (size_t)width * height; k++)
            to[k] = from[k];
    }
    return status;
}

/// One of the first two passes.
static rsv_status keep_half(
    rsv_context *context, rsv_sample_sum *sum, uint32_t index, const rsv_image *pass)
{
    rsv_status status = copy_layers(context, pass, 1, &sum->half[index]);
    if (status == RSV_OK && rsv_has_guides(pass))
        status = copy_layers(context, pass, rsv_image_layer_count(pass), &sum->side[index]);
    return status;
}

rsv_status rsv_sample_sum_add(
    rsv_context *context, rsv_sample_sum *sum, uint32_t samples, rsv_image *pass)
{
    rsv_status status = RSV_OK;
    if (!sum->half[1]) status = keep_half(context, sum, sum->half[0] ? 1 : 0, pass);
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

/// The same for both sides.
static rsv_status part_sides(rsv_context *context, rsv_sample_sum *sum, size_t pixels)
{
    for (int half = 0; half < 2; half++) {
        if (!sum->side[half]) continue;
        uint32_t *samples = rsv_alloc(context, pixels, sizeof *samples);
        if (!samples) return RSV_ERROR_MEMORY;
        for (size_t k = 0; k < pixels; k++)
            samples[k] = sum->half_samples;
        sum->side_samples[half] = samples;
    }
    return RSV_OK;
}

rsv_status rsv_sample_sum_part(rsv_context *context, rsv_sample_sum *sum, double fall)
{
    size_t pixels = (size_t)rsv_image_width(sum->mean) * rsv_image_height(sum->mean);
    uint32_t first = 2 * sum->half_samples;
    double to_one = RSV_ERROR_OF_HALVES * pow(first, fall), left = pow(sum->samples, -fall);
    if (sum->pixel) return RSV_OK;
    float *square = rsv_alloc(context, pixels, sizeof *square);
    sum->pixel = rsv_alloc(context, pixels, sizeof *sum->pixel);
    rsv_status status = square && sum->pixel ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) rsv_pixel_squares(sum->mean, sum->half[0], sum->half[1], square);
    for (size_t k = 0; status == RSV_OK && k < pixels; k++)
        sum->pixel[k] =
            (rsv_summed_pixel){ sum->samples, first, (float)(to_one * square[k]), (float)left };
    rsv_free(context, square);
    return status == RSV_OK ? part_sides(context, sum, pixels) : status;
}

double rsv_variance_left(const rsv_summed_pixel *pixel, double more, bool renewed, double fall)
{
    if (more == 0) return pixel->left;
    double share = renewed ? 1 : more / (pixel->taken + more);
    double of_pair = more < 2 ? 1 : pow(more, -fall);
    return (1 - share) * (1 - share) * (double)pixel->left + share * share * of_pair;
}

/// @param square relative difference of the two passes
static void count_samples(
    rsv_summed_pixel *pixel, uint32_t more, float square, float renewed, double fall)
{
    double left = rsv_variance_left(pixel, more, renewed > 0, fall);
    if (renewed > 0) *pixel = (rsv_summed_pixel){ .variance = renewed };
    pixel->taken += more;
    pixel->left = (float)left;
    if (more < 2) return;
    double scale = RSV_ERROR_OF_HALVES * pow(more, fall);
    float share = (float)more / (float)(pixel->looks += more);
    pixel->variance += share * ((float)(scale * (double)square) - pixel->variance);
}

/// One of the two passes, by the samples that each pixel has. @param before [pixels] of these
static void mix_uneven(rsv_image *mean, const rsv_uneven_pair *uneven, int half,
    const rsv_image *pass, uint32_t *before)
{
    size_t pixels = (size_t)rsv_image_width(pass) * rsv_image_height(pass);
    for (uint32_t layer = 0; layer < rsv_image_layer_count(pass); layer++) {
        rsv_rgb *to = rsv_image_pixels(mean, layer);
        const rsv_rgb *from = rsv_image_const_pixels(pass, layer);
        for (size_t k = 0; k < pixels; k++) {
            uint32_t count = rsv_uneven_half(uneven->count[k], half);
            if (count == 0) continue;
            float share = (float)count / (float)(before[k] + count);
            to[k] = rgb_mad(to[k], share, rgb_sub(from[k], to[k]));
        }
    }
    for (size_t k = 0; k < pixels; k++)
        before[k] += rsv_uneven_half(uneven->count[k], half);
}

/// Both passes, each to its side.
static void add_to_sides(
    rsv_sample_sum *sum, const rsv_uneven_pair *uneven, rsv_image *const pass[2])
{
    size_t pixels = (size_t)rsv_image_width(pass[0]) * rsv_image_height(pass[0]);
    for (int half = 0; half < 2; half++) {
        uint32_t *samples = sum->side_samples[half];
        if (!samples) continue;
        for (size_t k = 0; k < pixels; k++)
            if (uneven->renewed[k] > 0) samples[k] = 0;
        mix_uneven(sum->side[half], uneven, half, pass[half], samples);
    }
}

static void add_pair(rsv_sample_sum *sum, const rsv_uneven_pair *uneven, rsv_image *pass[2],
    float *square, uint32_t *before)
{
    size_t pixels = (size_t)rsv_image_width(pass[0]) * rsv_image_height(pass[0]);
    uint64_t all = 0;
    rsv_image_destroy(sum->clean);
    sum->clean = NULL;
    rsv_pixel_squares(sum->mean, pass[0], pass[1], square);
    for (size_t k = 0; k < pixels; k++)
        before[k] = uneven->renewed[k] > 0 ? 0 : sum->pixel[k].taken;
    for (int half = 0; half < 2; half++)
        mix_uneven(sum->mean, uneven, half, pass[half], before);
    add_to_sides(sum, uneven, pass);
    for (size_t k = 0; k < pixels; k++) {
        uint32_t count = uneven->count[k];
        if (count)
            count_samples(&sum->pixel[k], count, square[k], uneven->renewed[k], uneven->fall);
        all += sum->pixel[k].taken;
    }
    sum->samples = (uint32_t)((all + pixels / 2) / pixels);
}

rsv_status rsv_sample_sum_add_uneven(
    rsv_context *context, rsv_sample_sum *sum, const rsv_uneven_pair *uneven, rsv_image *pass[2])
{
    size_t pixels = (size_t)rsv_image_width(pass[0]) * rsv_image_height(pass[0]);
    float *square = rsv_alloc(context, pixels, sizeof *square);
    uint32_t *before = rsv_alloc(context, pixels, sizeof *before);
    rsv_status status = square && before ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) add_pair(sum, uneven, pass, square, before);
    rsv_free(context, square);
    rsv_free(context, before);
    rsv_image_destroy(pass[0]);
    rsv_image_destroy(pass[1]);
    return status;
}

rsv_status rsv_sample_sum_finish(rsv_context *context, rsv_sample_sum *sum, rsv_image **image)
{
    if (sum->clean) {
        *image = sum->clean;
        sum->clean = NULL;
        return RSV_OK;
    }
    if (sum->side[0] && sum->side[1]) return rsv_picture_filter(context, sum->side, image);
    if (rsv_has_guides(sum->mean)) return copy_layers(context, sum->mean, 1, image);
    *image = sum->mean;
    sum->mean = NULL;
    return RSV_OK;
}

/// The same of the filtered picture.
static double filtered_noise(const rsv_sample_sum *sum)
{
    size_t pixels = (size_t)rsv_image_width(sum->mean) * rsv_image_height(sum->mean);
    double noise = 0;
    for (size_t k = 0; k < pixels; k++)
        noise += fmin((double)sum->filtered_error[k], RSV_MOST_OF_A_PIXEL);
    return noise / (double)pixels;
}

double rsv_sample_sum_noise(const rsv_sample_sum *sum, double fall)
{
    if (sum->filtered_error) return filtered_noise(sum);
    const rsv_image *const first[2] = { sum->half[0], sum->half[0] };
    const rsv_image *const second[2] = { sum->half[1], sum->half[1] };
    const rsv_pixel_error_desc each = { .most = RSV_MOST_OF_A_PIXEL };
    double uncertainty, square = rsv_pixel_error(first, second, each, &uncertainty);
    double more = (double)sum->samples / (2 * (double)sum->half_samples);
    return RSV_ERROR_OF_HALVES * square * pow(more, -fall);
}

uint32_t rsv_samples_for(double excess, uint32_t samples, double fall, uint32_t most)
{
    double needed = ceil((double)samples * pow(excess, 1 / fall));
    return needed <= 1 ? 1 : needed < (double)most ? (uint32_t)needed : most;
}

void rsv_sample_sum_clear(rsv_context *context, rsv_sample_sum *sum)
{
    rsv_free(context, sum->pixel);
    for (int k = 0; k < 2; k++) {
        rsv_free(context, sum->side_samples[k]);
        rsv_image_destroy(sum->side[k]);
    }
    rsv_free(context, sum->filtered_error);
    rsv_free(context, sum->kept);
    rsv_image_destroy(sum->clean);
    rsv_free(context, sum->is_outline);
    rsv_image_destroy(sum->mean);
    rsv_image_destroy(sum->half[0]);
    rsv_image_destroy(sum->half[1]);
    *sum = (rsv_sample_sum){ 0 };
}
