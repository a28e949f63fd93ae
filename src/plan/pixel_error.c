#include "pixel_error.h"

#include "../core/vec.h"
#include "pixel_window.h"

typedef struct four_pictures {
    const rsv_rgb *a[2], *b[2];
    const rsv_rgb *light[2]; ///< that errors are relative to; NULL = all four
    int width, height;
    double floor;
    rsv_pixel_error_desc desc;
} four_pictures;

/// A sum over pixels.
typedef struct sum3 {
    double of[3], count;
} sum3;

static void add(sum3 *sum, rsv_rgb c, double factor)
{
    sum->of[0] += factor * (double)c.r;
    sum->of[1] += factor * (double)c.g;
    sum->of[2] += factor * (double)c.b;
}

static void add_light(const four_pictures *p, size_t pixel, sum3 *sum)
{
    for (int k = 0; k < 2; k++) {
        if (p->light[k]) {
            add(sum, p->light[k][pixel], 0.5);
        } else {
            add(sum, p->a[k][pixel], 0.25);
            add(sum, p->b[k][pixel], 0.25);
        }
    }
    sum->count++;
}

static rsv_pixel_window around(const four_pictures *p, int x, int y)
{
    return rsv_pixel_window_around(p->width, p->height, x, y, RSV_PIXEL_SURROUNDINGS);
}

static sum3 local_light(const four_pictures *p, int x, int y)
{
    rsv_pixel_window w = around(p, x, y);
    sum3 sum = { .count = 0 };
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++)
            add_light(p, (size_t)j * p->width + i, &sum);
    return sum;
}

/// a - b of one pair.
static sum3 difference_at(const four_pictures *p, int pair, int x, int y)
{
    size_t pixel = (size_t)y * p->width + x;
    sum3 difference = { .count = 1 };
    add(&difference, rgb_sub(p->a[pair][pixel], p->b[pair][pixel]), 1);
    return difference;
}

/// Mean over the channels of a product, each relative to its surroundings, as in rsv_image_judge.
static double relative(
    const four_pictures *p, const sum3 *first, const sum3 *second, const sum3 *light)
{
    double error = 0;
    for (int c = 0; c < 3; c++) {
        double product = first->of[c] * second->of[c], mean = light->of[c] / light->count;
        if (product != 0) error += product / (3 * (mean * mean + p->floor)); // 0 where all is black
    }
    return error;
}

static double error_at(const four_pictures *p, int x, int y)
{
    sum3 first = difference_at(p, 0, x, y), second = difference_at(p, 1, x, y);
    sum3 light = local_light(p, x, y);
    double error = relative(p, &first, &second, &light);
    return fmax(fmin(error, p->desc.most), -p->desc.most);
}

static four_pictures begin(
    const rsv_image *const a[2], const rsv_image *const b[2], rsv_pixel_error_desc desc)
{
    four_pictures p = {
        .desc = desc, .width = (int)rsv_image_width(a[0]), .height = (int)rsv_image_height(a[0])
    };
    sum3 light = { .count = 0 };
    for (int k = 0; k < 2; k++) {
        p.a[k] = rsv_image_const_pixels(a[k], 0);
        p.b[k] = rsv_image_const_pixels(b[k], 0);
        if (desc.light) p.light[k] = rsv_image_const_pixels(desc.light[k], 0);
    }
    for (size_t k = 0; k < (size_t)p.width * p.height; k++)
        add_light(&p, k, &light);
    double mean = (light.of[0] + light.of[1] + light.of[2]) / (3 * light.count);
    p.floor = RSV_PIXEL_FLOOR * mean * mean;
    return p;
}

static rsv_rgb lower(rsv_rgb a, rsv_rgb b)
{
    return rgb(f_min(a.r, b.r), f_min(a.g, b.g), f_min(a.b, b.b));
}

/// Mean of a picture around a pixel, which counts with the lower of two values.
static sum3 light_beside(const four_pictures *p, int x, int y)
{
    rsv_pixel_window w = around(p, x, y);
    size_t pixel = (size_t)y * p->width + x;
    sum3 sum = { .count = 0 };
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++) {
            add(&sum, p->a[0][(size_t)j * p->width + i], 1);
            sum.count++;
        }
    add(&sum, p->a[0][pixel], -1);
    add(&sum, lower(p->b[0][pixel], p->b[1][pixel]), 1);
    return sum;
}

static double square_at(const four_pictures *p, int x, int y)
{
    size_t pixel = (size_t)y * p->width + x;
    sum3 difference = { .count = 1 }, light = light_beside(p, x, y);
    add(&difference, rgb_sub(p->b[0][pixel], p->b[1][pixel]), 1);
    return relative(p, &difference, &difference, &light);
}

void rsv_pixel_squares(const rsv_image *mean, const rsv_image *a, const rsv_image *b, float *map)
{
    const rsv_image *const light[2] = { mean, mean }, *const pair[2] = { a, b };
    four_pictures p = begin(light, pair, (rsv_pixel_error_desc){ .light = light });
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++)
            map[(size_t)y * p.width + x] = (float)square_at(&p, x, y);
}

double rsv_pixel_error(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double *uncertainty)
{
    four_pictures p = begin(a, b, desc);
    double count = 0, sum = 0, squares = 0;
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++) {
            if (desc.spots && desc.spots[(size_t)y * p.width + x] == 0) continue;
            count++;
            double error = error_at(&p, x, y);
            sum += error;
            squares += error * error;
        }
    *uncertainty = sqrt(fmax(squares / count - sum * sum / count / count, 0) / count);
    return sum / count;
}
