#include "selection.h"

#include "../core/vec.h"
#include "pixel_window.h"

#include <math.h>
#include <stdlib.h>

/// A pixel is judged with those around it that have this many gather rays together, at most so far on either side.
#define RAYS_JUDGED 200
#define FARTHEST 5
/// Standard errors by which a squared error must exceed the limit.
#define CERTAINTY 0.7

typedef struct pictures {
    const rsv_rgb *stored[2], *gathered[2];
    int width, height;
    int reach; ///< pixels on either side that a pixel is judged with
    double floor;
} pictures;

/// Sums over differences that are independent but for their mean.
typedef struct sums {
    double weights, squared_weights;
    double differences, squares; ///< of weighted differences
} sums;

static rsv_pixel_window around(const pictures *p, int x, int y, int reach)
{
    return rsv_pixel_window_around(p->width, p->height, x, y, reach);
}

static double brightness(const pictures *p, size_t pixel)
{
    return 0.5 * (double)(rgb_luminance(p->stored[0][pixel]) + rgb_luminance(p->stored[1][pixel]));
}

static double squared_light(const pictures *p, int x, int y)
{
    rsv_pixel_window w = around(p, x, y, RSV_PIXEL_SURROUNDINGS);
    double sum = 0, count = (w.right - w.left + 1.0) * (w.bottom - w.top + 1.0);
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++)
            sum += brightness(p, (size_t)j * p->width + i);
    return sum * sum / (count * count) + p->floor;
}

static void add(const pictures *p, size_t pixel, double weight, sums *s)
{
    for (int k = 0; k < 2; k++) {
        rsv_rgb difference = rgb_sub(p->stored[k][pixel], p->gathered[k][pixel]);
        double d = weight * (double)rgb_luminance(difference);
        s->weights += weight;
        s->squared_weights += weight * weight;
        s->differences += d;
        s->squares += d * d;
    }
}

/// The nearer a pixel, the more it counts.
static sums add_up(const pictures *p, int x, int y)
{
    rsv_pixel_window w = around(p, x, y, p->reach);
    sums s = { 0 };
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++) {
            int near = (p->reach + 1 - abs(i - x)) * (p->reach + 1 - abs(j - y));
            add(p, (size_t)j * p->width + i, near, &s);
        }
    return s;
}

/// Compares the squared mean difference with a limit. All products of two different ones give it without their noise.
static bool is_above(const sums *s, double limit)
{
    double all = s->weights * s->weights;
    double square = (s->differences * s->differences - s->squares) / (all - s->squared_weights);
    double noisy = s->differences * s->differences / all;
    double variance = fmax(s->squares - noisy * s->squared_weights, 0) / all; // of the mean
    double doubt = sqrt(2 * variance * variance + 4 * noisy * variance);
    return square > limit + CERTAINTY * doubt;
}

/// Pixels on either side that have enough gather rays, weighted.
static int reach_for(double rays)
{
    int reach = 0;
    double pixels = 1; // as many, evenly weighted, would have the same noise
    while (reach < FARTHEST && rays * pixels < RAYS_JUDGED) {
        double n = ++reach + 1, line = 3 * n * n * n / (2 * n * n + 1);
        pixels = line * line;
    }
    return reach;
}

static pictures begin(const rsv_image *const stored[2], const rsv_image *const gathered[2])
{
    pictures p = { .width = (int)rsv_image_width(stored[0]),
        .height = (int)rsv_image_height(stored[0]) };
    double mean = 0, pixels = (double)p.width * p.height;
    for (int k = 0; k < 2; k++) {
        p.stored[k] = rsv_image_const_pixels(stored[k], 0);
        p.gathered[k] = rsv_image_const_pixels(gathered[k], 0);
    }
    for (size_t k = 0; k < (size_t)p.width * p.height; k++)
        mean += brightness(&p, k) / pixels;
    p.floor = RSV_PIXEL_FLOOR * mean * mean;
    return p;
}

double rsv_select_pixels(const rsv_image *const stored[2], const rsv_image *const gathered[2],
    const rsv_selection_desc *desc, uint8_t *chosen)
{
    pictures p = begin(stored, gathered);
    double count = 0;
    p.reach = reach_for(desc->rays);
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++) {
            sums s = add_up(&p, x, y);
            bool wrong = is_above(&s, desc->limit * squared_light(&p, x, y));
            chosen[(size_t)y * p.width + x] = wrong;
            count += wrong;
        }
    return count / ((double)p.width * p.height);
}
