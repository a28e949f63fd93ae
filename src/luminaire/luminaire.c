/// Intensities between the angles of a file, by its symmetry, and their integral.
#include "resolvent/luminaire.h"
#include "../core/core.h"
#include "../core/vec.h"

#include <math.h>

#define DEGREES (M_PI / 180)
#define SLACK 1e-3 ///< degrees that a file's last angle may fall short

/// The interval of ascending angles that holds a value, and where in it. @return false beyond them
static bool find_interval(
    const float *angle, uint32_t count, double value, uint32_t *index, double *within)
{
    if (value < (double)angle[0] - SLACK || value > (double)angle[count - 1] + SLACK) return false;
    uint32_t low = 0, high = count - 1;
    while (high - low > 1) {
        uint32_t middle = (low + high) / 2;
        if ((double)angle[middle] <= value)
            low = middle;
        else
            high = middle;
    }
    double step = (double)(angle[high] - angle[low]);
    *index = low;
    *within = step > 0 ? fmin(fmax((value - (double)angle[low]) / step, 0), 1) : 0;
    return true;
}

/// Brings a horizontal angle of type C into what the file holds.
static double fold_c(const rsv_luminaire *l, double c)
{
    double first = (double)l->horizontal[0], last = (double)l->horizontal[l->horizontal_count - 1];
    double span = last - first;
    if (l->horizontal_count == 1) return first;
    c = fmod(fmod(c - first, 360) + 360, 360); // from the first plane on
    if (span > 180 + SLACK) return first + c;  // planes all around
    if (c > 180) c = 360 - c;                  // mirrored at the first plane
    if (span > 90 + SLACK) return first + c;
    return first + (c > 90 ? 180 - c : c); // at the second one as well
}

/// Of types A and B, which may state one half of the angles.
static double fold_half(const float *angle, double value)
{
    return angle[0] >= 0 ? fabs(value) : value;
}

static void find_angles(const rsv_luminaire *l, rsv_vec3 d, double *vertical, double *horizontal)
{
    double x = (double)d.x, y = (double)d.y, z = (double)d.z;
    if (l->type == RSV_PHOTOMETRY_C) {
        *vertical = atan2(hypot(x, z), -y) / DEGREES;
        *horizontal = fold_c(l, atan2(z, x) / DEGREES);
        return;
    }
    bool floodlight = l->type == RSV_PHOTOMETRY_B;
    double latitude = atan2(floodlight ? x : y, floodlight ? hypot(y, z) : hypot(x, z)) / DEGREES;
    double turn = atan2(floodlight ? y : x, z) / DEGREES;
    *vertical = fold_half(l->vertical, floodlight ? turn : latitude);
    *horizontal = fold_half(l->horizontal, floodlight ? latitude : turn);
}

double rsv_luminaire_intensity(const rsv_luminaire *l, rsv_vec3 direction)
{
    double vertical, horizontal, v, h;
    uint32_t i, j;
    find_angles(l, direction, &vertical, &horizontal);
    if (!find_interval(l->vertical, l->vertical_count, vertical, &i, &v) ||
        !find_interval(l->horizontal, l->horizontal_count, horizontal, &j, &h))
        return 0;
    const float *near = l->intensity + (size_t)j * l->vertical_count + i;
    const float *far = near + (j + 1 < l->horizontal_count ? l->vertical_count : 0);
    uint32_t next = i + 1 < l->vertical_count;
    return (1 - h) * ((1 - v) * (double)near[0] + v * (double)near[next]) +
           h * ((1 - v) * (double)far[0] + v * (double)far[next]);
}

/// Weights of the ends of an interval of latitudes, radians from the pole on, of a function that is linear in between, times the sine.
static void sine_weights(double a, double b, double weight[2])
{
    double step = b - a;
    double all = cos(a) - cos(b); // of sin
    double first =
        step > 0 ? (sin(b) - sin(a) - step * cos(b)) / step : 0; // of sin times (x - a) / step
    weight[0] = all - first;
    weight[1] = first;
}

/// Part of a turn that each horizontal angle stands for, radians: half of the intervals beside it, as often as symmetry repeats them.
static double turn_weight(const float *angle, uint32_t count, uint32_t k, double repeats)
{
    double low = (double)angle[k > 0 ? k - 1 : 0],
           high = (double)angle[k + 1 < count ? k + 1 : count - 1];
    return count == 1 ? 2 * M_PI : repeats * 0.5 * (high - low) * DEGREES;
}

/// How often what the file holds goes round.
static double repeats_of(const rsv_luminaire *l, const float *turn, uint32_t count)
{
    double span = (double)(turn[count - 1] - turn[0]);
    if (l->type == RSV_PHOTOMETRY_C) return span > 180 + SLACK ? 1 : span > 90 + SLACK ? 2 : 4;
    return turn[0] >= 0 ? 2 : 1;
}

/// Integral over latitudes of a row of intensities. @param stride between its values
static double integrate_latitudes(const rsv_luminaire *l, const float *latitude, uint32_t count,
    const float *value, size_t stride)
{
    double sum = 0;
    for (uint32_t k = 0; k + 1 < count; k++) {
        double a = (double)latitude[k] * DEGREES, b = (double)latitude[k + 1] * DEGREES, weight[2];
        bool from_pole = l->type == RSV_PHOTOMETRY_C;
        sine_weights(from_pole ? a : a + M_PI / 2, from_pole ? b : b + M_PI / 2, weight);
        sum += weight[0] * (double)value[k * stride] + weight[1] * (double)value[(k + 1) * stride];
    }
    return !(l->type == RSV_PHOTOMETRY_C) && latitude[0] >= 0 ? 2 * sum : sum;
}

double rsv_luminaire_flux(const rsv_luminaire *l)
{
    bool floodlight = l->type == RSV_PHOTOMETRY_B; // latitudes are its horizontal angles
    const float *turn = floodlight ? l->vertical : l->horizontal,
                *latitude = floodlight ? l->horizontal : l->vertical;
    uint32_t turns = floodlight ? l->vertical_count : l->horizontal_count;
    uint32_t latitudes = floodlight ? l->horizontal_count : l->vertical_count;
    double flux = 0, repeats = repeats_of(l, turn, turns);
    for (uint32_t k = 0; k < turns; k++) {
        const float *row = l->intensity + (floodlight ? k : (size_t)k * l->vertical_count);
        flux += turn_weight(turn, turns, k, repeats) * integrate_latitudes(l, latitude, latitudes,
                                                           row, floodlight ? l->vertical_count : 1);
    }
    return flux;
}

double rsv_luminaire_peak(const rsv_luminaire *l)
{
    double peak = 0;
    for (size_t k = 0; k < (size_t)l->vertical_count * l->horizontal_count; k++)
        peak = fmax(peak, (double)l->intensity[k]);
    return peak;
}
