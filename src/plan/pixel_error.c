#include "pixel_error.h"

#include "../core/vec.h"

/// Pixels on either side over which brightness is averaged, and the part of the picture's that counts as the least.
#define NEIGHBOURHOOD 2
#define FLOOR 0.01

typedef struct four_pictures {
    const rsv_rgb *a[2], *b[2];
    int width, height, around;
    double floor, most;
    bool by_a;
} four_pictures;

static double luminance_of(const four_pictures *p, size_t pixel)
{
    rsv_rgb a = rgb_add(p->a[0][pixel], p->a[1][pixel]);
    if (p->by_a) return 0.5 * (double)rgb_luminance(a);
    return 0.25 * (double)rgb_luminance(rgb_add(a, rgb_add(p->b[0][pixel], p->b[1][pixel])));
}

static double local_luminance(const four_pictures *p, int x, int y)
{
    double sum = 0, count = 0;
    for (int j = y - NEIGHBOURHOOD; j <= y + NEIGHBOURHOOD; j++)
        for (int i = x - NEIGHBOURHOOD; i <= x + NEIGHBOURHOOD; i++) {
            if (i < 0 || j < 0 || i >= p->width || j >= p->height) continue;
            sum += luminance_of(p, (size_t)j * p->width + i);
            count++;
        }
    return sum / count;
}

/// Mean luminance of a - b of one pair over the pixels around one.
static double difference_at(const four_pictures *p, int pair, int x, int y)
{
    double sum = 0, count = 0;
    for (int j = y - p->around; j <= y + p->around; j++)
        for (int i = x - p->around; i <= x + p->around; i++) {
            if (i < 0 || j < 0 || i >= p->width || j >= p->height) continue;
            size_t k = (size_t)j * p->width + i;
            sum += (double)rgb_luminance(rgb_sub(p->a[pair][k], p->b[pair][k]));
            count++;
        }
    return sum / count;
}

static double error_at(const four_pictures *p, int x, int y)
{
    double product = difference_at(p, 0, x, y) * difference_at(p, 1, x, y);
    if (product == 0) return 0; // also where all is black
    double light = local_luminance(p, x, y);
    return fmax(fmin(product / (light * light + p->floor), p->most), -p->most);
}

/// By how much the standard error of a mean over all pixels grows as squares of this edge overlap: products of two means
/// correlate by the square of what their squares share.
static double overlap(double edge) { return (2 * edge * edge + 1) / (3 * edge); }

double rsv_pixel_error(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double *uncertainty)
{
    four_pictures p = { .most = desc.most,
        .around = (int)desc.around,
        .by_a = desc.by_a,
        .width = (int)rsv_image_width(a[0]),
        .height = (int)rsv_image_height(a[0]) };
    double count = (double)p.width * p.height, light = 0, sum = 0, squares = 0;
    for (int k = 0; k < 2; k++) {
        p.a[k] = rsv_image_const_pixels(a[k], 0);
        p.b[k] = rsv_image_const_pixels(b[k], 0);
    }
    for (size_t k = 0; k < (size_t)p.width * p.height; k++)
        light += luminance_of(&p, k) / count;
    p.floor = FLOOR * light * light;
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++) {
            double error = error_at(&p, x, y);
            sum += error;
            squares += error * error;
        }
    *uncertainty = sqrt(fmax(squares / count - sum * sum / count / count, 0) / count) *
                   overlap(2.0 * desc.around + 1);
    return sum / count;
}
