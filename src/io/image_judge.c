#include "../core/vec.h"
#include "image_internal.h"

/// Pixels on either side of one over which the references are averaged to say how bright it is: their noise must not
/// decide how much that very noise counts.
#define NEIGHBOURHOOD 2

/// The pictures as the channels of their pixels.
typedef struct trial {
    const float *a[2], *b; ///< [height * width * 3]
    uint32_t width, height;
    double floor; ///< 0.01 mean(a)^2
} trial;

static const float *channels_of(const rsv_image *image, uint32_t layer)
{
    return &rsv_image_const_pixels(image, layer)->r;
}

static double mean_of_references(const trial *t)
{
    size_t count = (size_t)t->width * t->height * 3;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += 0.5 * ((double)t->a[0][i] + (double)t->a[1][i]);
    return sum / (double)count;
}

/// Mean of the references around a pixel, as far as the picture goes.
static double local_mean(const trial *t, uint32_t x, uint32_t y, uint32_t channel)
{
    uint32_t x0 = x < NEIGHBOURHOOD ? 0 : x - NEIGHBOURHOOD;
    uint32_t y0 = y < NEIGHBOURHOOD ? 0 : y - NEIGHBOURHOOD;
    uint32_t x1 = x + NEIGHBOURHOOD < t->width ? x + NEIGHBOURHOOD : t->width - 1;
    uint32_t y1 = y + NEIGHBOURHOOD < t->height ? y + NEIGHBOURHOOD : t->height - 1;
    double sum = 0;
    for (uint32_t j = y0; j <= y1; j++) {
        for (uint32_t i = x0; i <= x1; i++) {
            size_t k = 3 * ((size_t)j * t->width + i) + channel;
            sum += 0.5 * ((double)t->a[0][k] + (double)t->a[1][k]);
        }
    }
    return sum / ((x1 - x0 + 1) * (y1 - y0 + 1));
}

/// Adds the mean of the pixel's channels to the square errors of b and of the references' mean.
static void judge_pixel(const trial *t, uint32_t x, uint32_t y, double *own, double *reference)
{
    *own = *reference = 0;
    for (uint32_t channel = 0; channel < 3; channel++) {
        size_t k = 3 * ((size_t)y * t->width + x) + channel;
        double brightness = local_mean(t, x, y, channel), b = (double)t->b[k];
        double first = b - (double)t->a[0][k], second = b - (double)t->a[1][k];
        double scale = 3 * (brightness * brightness + t->floor);
        if (first * second != 0) *own += first * second / scale;
        if (first != second) *reference += 0.25 * (first - second) * (first - second) / scale;
    }
}

static void judge(trial *t, rsv_image_judgement *judgement)
{
    double count = (double)t->width * t->height, sum = 0, squares = 0, reference_sum = 0;
    double mean = mean_of_references(t);
    t->floor = 0.01 * mean * mean;
    for (uint32_t y = 0; y < t->height; y++) {
        for (uint32_t x = 0; x < t->width; x++) {
            double own, reference;
            judge_pixel(t, x, y, &own, &reference);
            sum += own;
            squares += own * own;
            reference_sum += reference;
        }
    }
    judgement->relative_mse = sum / count;
    judgement->relative_mse_error =
        sqrt(fmax(squares / count - sum * sum / count / count, 0) / count);
    judgement->reference_mse = reference_sum / count;
}

rsv_status rsv_image_judge(const rsv_image *const a[2], const uint32_t layer_a[2],
    const rsv_image *b, uint32_t layer_b, rsv_image_judgement *judgement)
{
    trial t = { .width = rsv_image_width(b), .height = rsv_image_height(b) };
    for (int k = 0; k < 2; k++) {
        rsv_status status = rsv_image_check_pair(a[k], layer_a[k], b, layer_b);
        if (status != RSV_OK) return status;
        t.a[k] = channels_of(a[k], layer_a[k]);
    }
    t.b = channels_of(b, layer_b);
    judge(&t, judgement);
    return RSV_OK;
}
