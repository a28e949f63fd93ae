#include "pixel_error.h"

#include "../core/vec.h"

/// Pixels on either side over which brightness is averaged, and the part of the picture's that counts as the least.
#define NEIGHBOURHOOD 2
#define FLOOR 0.01
/// After averaging over squares of side w, such errors decrease about as w^-p: p = 0 if they are uniform, 1 along
/// lines, 2 at points. Until an estimate determines it, p has this usual value (two-rooms 0.5, modern hall 0.1).
#define USUAL_DECAY 0.3
#define MOST_DECAY 2.0

typedef struct four_pictures {
    const rsv_rgb *a[2], *b[2];
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
    double share = p->desc.by_a ? 0.5 : 0.25;
    for (int k = 0; k < 2; k++) {
        add(sum, p->a[k][pixel], share);
        if (!p->desc.by_a) add(sum, p->b[k][pixel], share);
    }
    sum->count++;
}

/// Adds a - b of one pair.
static void add_difference(const four_pictures *p, int pair, size_t pixel, sum3 *sum)
{
    add(sum, rgb_sub(p->a[pair][pixel], p->b[pair][pixel]), 1);
    sum->count++;
}

/// The part of the picture around a pixel.
typedef struct window {
    int left, right, top, bottom; ///< inclusive
} window;

static window around(const four_pictures *p, int x, int y, int reach)
{
    return (window){ x < reach ? 0 : x - reach, x + reach < p->width ? x + reach : p->width - 1,
        y < reach ? 0 : y - reach, y + reach < p->height ? y + reach : p->height - 1 };
}

static sum3 local_light(const four_pictures *p, int x, int y)
{
    window w = around(p, x, y, NEIGHBOURHOOD);
    sum3 sum = { .count = 0 };
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++)
            add_light(p, (size_t)j * p->width + i, &sum);
    return sum;
}

static sum3 local_difference(const four_pictures *p, int pair, int x, int y)
{
    window w = around(p, x, y, (int)p->desc.around);
    sum3 sum = { .count = 0 };
    for (int j = w.top; j <= w.bottom; j++)
        for (int i = w.left; i <= w.right; i++)
            add_difference(p, pair, (size_t)j * p->width + i, &sum);
    return sum;
}

/// Mean over the channels, each relative to its surroundings, as in rsv_image_judge.
static double error_at(const four_pictures *p, int x, int y)
{
    sum3 first = local_difference(p, 0, x, y), second = local_difference(p, 1, x, y);
    sum3 light = local_light(p, x, y);
    double error = 0, pairs = first.count * second.count;
    for (int c = 0; c < 3; c++) {
        double product = first.of[c] * second.of[c] / pairs, mean = light.of[c] / light.count;
        if (product != 0) error += product / (3 * (mean * mean + p->floor)); // 0 where all is black
    }
    return fmax(fmin(error, p->desc.most), -p->desc.most);
}

/// Factor of the standard error of a mean over all pixels, due to overlapping squares of this side: products of two
/// means correlate by the square of their overlap.
static double overlap(double edge) { return (2 * edge * edge + 1) / (3 * edge); }

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
    }
    for (size_t k = 0; k < (size_t)p.width * p.height; k++)
        add_light(&p, k, &light);
    double mean = (light.of[0] + light.of[1] + light.of[2]) / (3 * light.count);
    p.floor = FLOOR * mean * mean;
    return p;
}

void rsv_pixel_error_map(
    const rsv_image *const a[2], const rsv_image *const b[2], rsv_pixel_error_desc desc, float *map)
{
    four_pictures p = begin(a, b, desc);
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++)
            map[(size_t)y * p.width + x] = (float)error_at(&p, x, y);
}

double rsv_pixel_error(const rsv_image *const a[2], const rsv_image *const b[2],
    rsv_pixel_error_desc desc, double *uncertainty)
{
    four_pictures p = begin(a, b, desc);
    double count = (double)p.width * p.height, sum = 0, squares = 0;
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

static double edge_of(rsv_pixel_error_desc desc) { return 2.0 * desc.around + 1; }

double rsv_pixel_error_averaged_away(const rsv_image *const stored[2],
    const rsv_image *const truth[2], rsv_pixel_error_desc desc, double error, double uncertainty)
{
    double decay = USUAL_DECAY, unused, edge = edge_of(desc);
    if (desc.around > 1 && error > 0) {
        desc.around--;
        double finer = rsv_pixel_error(stored, truth, desc, &unused);
        double found = log(fmax(finer / error, 1)) / log(edge / edge_of(desc));
        double certain = error * error / (error * error + uncertainty * uncertainty);
        decay += certain * (fmin(found, MOST_DECAY) - decay);
    }
    return pow(edge, decay);
}
