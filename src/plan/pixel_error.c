#include "pixel_error.h"

#include "../core/vec.h"

/// Pixels on either side over which brightness is averaged, and the part of the picture's that counts as the least.
#define NEIGHBOURHOOD 2
#define FLOOR 0.01

typedef struct four_pictures {
    const rsv_rgb *a[2], *b[2];
    int width, height;
    double floor, most;
} four_pictures;

static double luminance_of(const four_pictures *p, size_t pixel)
{
    rsv_rgb a = rgb_add(p->a[0][pixel], p->a[1][pixel]);
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

static double error_at(const four_pictures *p, int x, int y)
{
    size_t k = (size_t)y * p->width + x;
    double product = (double)rgb_luminance(rgb_sub(p->a[0][k], p->b[0][k])) *
                     (double)rgb_luminance(rgb_sub(p->a[1][k], p->b[1][k]));
    if (product == 0) return 0; // also where all is black
    double light = local_luminance(p, x, y);
    return fmax(fmin(product / (light * light + p->floor), p->most), -p->most);
}

double rsv_pixel_error(
    const rsv_image *const a[2], const rsv_image *const b[2], double most, double *uncertainty)
{
    four_pictures p = {
        .most = most, .width = (int)rsv_image_width(a[0]), .height = (int)rsv_image_height(a[0])
    };
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
    *uncertainty = sqrt(fmax(squares / count - sum * sum / count / count, 0) / count);
    return sum / count;
}
