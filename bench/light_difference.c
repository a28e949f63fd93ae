#include "light_difference.h"

#include <math.h>
#include <stdlib.h>

/// Points at which solutions are compared.
enum { POINTS = 200000 };

/// Numbers in [0, 1) evenly over three dimensions (Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences").
static void place_point(size_t k, double u[3])
{
    static const double step[3] = { 0.8191725133961645, 0.6710436067037893, 0.5497004779019703 };
    for (int i = 0; i < 3; i++)
        u[i] = fmod(0.5 + (double)(k + 1) * step[i], 1);
}

static double area_of(const rsv_scene_view *view, size_t t)
{
    const rsv_vec3 *p[3];
    for (int k = 0; k < 3; k++)
        p[k] = &view->position[view->triangle[t][k]];
    double a[3] = { (double)p[1]->x - p[0]->x, (double)p[1]->y - p[0]->y,
        (double)p[1]->z - p[0]->z };
    double b[3] = { (double)p[2]->x - p[0]->x, (double)p[2]->y - p[0]->y,
        (double)p[2]->z - p[0]->z };
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
           z = a[0] * b[1] - a[1] * b[0];
    return 0.5 * sqrt(x * x + y * y + z * z);
}

static double luminance_at(const rsv_light *s, uint32_t t, double u, double v)
{
    rsv_rgb e = rsv_light_irradiance(s, t, (float)u, (float)v, false, RSV_NONE);
    return 0.2126 * (double)e.r + 0.7152 * (double)e.g + 0.0722 * (double)e.b;
}

double cli_light_difference(const rsv_light *a, const rsv_light *b)
{
    const rsv_scene_view *view = rsv_scene_get_view(rsv_light_scene(a));
    double *sum = malloc((view->triangle_count + 1) * sizeof *sum), squares = 0, all = 0;
    if (!sum) return NAN;
    sum[0] = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        sum[t + 1] = sum[t] + area_of(view, t);
    for (size_t k = 0; k < POINTS; k++) {
        double u[3];
        place_point(k, u);
        double at = u[0] * sum[view->triangle_count];
        size_t low = 0, high = view->triangle_count;
        while (high - low > 1) {
            size_t middle = (low + high) / 2;
            *(sum[middle] <= at ? &low : &high) = middle;
        }
        double root = sqrt(u[1]), y = root * u[2], x = 1 - root;
        double first = luminance_at(a, (uint32_t)low, x, y);
        double second = luminance_at(b, (uint32_t)low, x, y);
        squares += (first - second) * (first - second);
        all += first * first;
    }
    free(sum);
    return sqrt(squares / all);
}
