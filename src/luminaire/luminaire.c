/// Intensities between the angles of a file, by its symmetry, and their integral.
#include "../core/core.h"
#include "intensity.h"
#include "luminaire_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEGREES (M_PI / 180)
#define SLACK RSV_LUMINAIRE_SLACK

double rsv_luminaire_intensity(const rsv_luminaire *l, rsv_vec3 direction)
{
    return rsv_luminaire_towards(l, (double)direction.x, (double)direction.y, -(double)direction.z);
}

/// Weights of the ends of an interval of latitudes, radians from the pole on, of a function that is linear in between,
/// times the sine.
static void sine_weights(double a, double b, double weight[2])
{
    double step = b - a;
    double all = cos(a) - cos(b); // of sin
    double first =
        step > 0 ? (sin(b) - sin(a) - step * cos(b)) / step : 0; // of sin times (x - a) / step
    weight[0] = all - first;
    weight[1] = first;
}

/// Part of a turn for each horizontal angle, radians: half of the neighbouring intervals, repeated by symmetry.
static double turn_weight(const float *angle, uint32_t count, uint32_t k, double repeats)
{
    double low = (double)angle[k > 0 ? k - 1 : 0],
           high = (double)angle[k + 1 < count ? k + 1 : count - 1];
    return count == 1 ? 2 * M_PI : repeats * 0.5 * (high - low) * DEGREES;
}

/// How often symmetry repeats the stored range in a full turn.
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

/// Largest angle to the axis, degrees, of a row's intensities above 0.
static double widest_of_row(const rsv_luminaire *l, const float *row)
{
    uint32_t last = l->vertical_count;
    while (last > 0 && !(row[last - 1] > 0))
        last--;
    if (last == 0) return 0;
    return (double)l->vertical[last < l->vertical_count ? last : last - 1]; // linear up to the next
}

double rsv_luminaire_cutoff(const rsv_luminaire *l)
{
    double widest = 0;
    if (l->type != RSV_PHOTOMETRY_C) return 180;
    for (uint32_t k = 0; k < l->horizontal_count; k++)
        widest = fmax(widest, widest_of_row(l, l->intensity + (size_t)k * l->vertical_count));
    return fmin(widest + SLACK, 180);
}

rsv_vec3 rsv_luminaire_opening(const rsv_luminaire *l)
{
    bool is_c = l->type == RSV_PHOTOMETRY_C, round = l->width < 0 || l->length < 0;
    double side = is_c ? l->length : l->width, across = is_c ? l->width : l->height,
           deep = is_c ? l->height : l->length;
    if (round && is_c && across == 0) across = side;
    if (round && is_c && side == 0) side = across;
    float sign = round && is_c ? -1 : 1;
    return (rsv_vec3){ sign * (float)fabs(side), sign * (float)fabs(across), (float)fabs(deep) };
}

rsv_status rsv_luminaire_copy(rsv_context *context, const rsv_luminaire *from, rsv_luminaire *to)
{
    size_t vertical = from->vertical_count, horizontal = from->horizontal_count;
    *to = *from;
    to->vertical = rsv_alloc(context, vertical, sizeof *to->vertical);
    to->horizontal = rsv_alloc(context, horizontal, sizeof *to->horizontal);
    to->intensity = rsv_alloc(context, vertical * horizontal, sizeof *to->intensity);
    if (!to->vertical || !to->horizontal || !to->intensity) return RSV_ERROR_MEMORY;
    memcpy(to->vertical, from->vertical, vertical * sizeof *to->vertical);
    memcpy(to->horizontal, from->horizontal, horizontal * sizeof *to->horizontal);
    memcpy(to->intensity, from->intensity, vertical * horizontal * sizeof *to->intensity);
    return RSV_OK;
}

/// Whether angles ascend within a turn. Files are checked as they are read.
static bool are_angles(const float *angle, uint32_t count)
{
    bool sound = angle && count > 0;
    for (uint32_t k = 0; sound && k < count; k++)
        sound = fabsf(angle[k]) <= 720 && (k == 0 || angle[k] > angle[k - 1]);
    return sound;
}

static bool lies_within(const float *angle, uint32_t count, double low, double high)
{
    return (double)angle[0] >= low - SLACK && (double)angle[count - 1] <= high + SLACK;
}

bool rsv_luminaire_is_on_sphere(const rsv_luminaire *l)
{
    double turn = (double)l->horizontal[l->horizontal_count - 1] - (double)l->horizontal[0];
    if (l->type == RSV_PHOTOMETRY_C)
        return lies_within(l->vertical, l->vertical_count, 0, 180) && turn <= 360 + SLACK;
    bool floodlight = l->type == RSV_PHOTOMETRY_B; // latitudes are its horizontal angles
    const float *latitude = floodlight ? l->horizontal : l->vertical;
    return lies_within(latitude, floodlight ? l->horizontal_count : l->vertical_count, -90, 90);
}

rsv_status rsv_luminaire_check(const rsv_luminaire *l)
{
    bool sound = (unsigned)l->type <= RSV_PHOTOMETRY_A && l->intensity &&
                 are_angles(l->vertical, l->vertical_count) &&
                 are_angles(l->horizontal, l->horizontal_count) && rsv_luminaire_is_on_sphere(l);
    for (size_t k = 0; sound && k < (size_t)l->vertical_count * l->horizontal_count; k++)
        sound = l->intensity[k] >= 0 && l->intensity[k] <= 1e30f;
    sound = sound && isfinite(l->width) && isfinite(l->length) && isfinite(l->height);
    if (sound) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "luminaire '%.100s': its angles do not ascend, or its intensities are not usable", l->name);
}

rsv_status rsv_luminaire_print(rsv_context *context, const rsv_luminaire *l, char **text)
{
    char *made = NULL;
    size_t bytes = 0, count = (size_t)l->vertical_count * l->horizontal_count;
    FILE *to = open_memstream(&made, &bytes);
    *text = NULL;
    if (!to) return RSV_ERROR_MEMORY;
    int type = l->type == RSV_PHOTOMETRY_C ? 1 : l->type == RSV_PHOTOMETRY_B ? 2 : 3;
    fprintf(to,
        "IESNA:LM-63-2002\n[LUMINAIRE] %s\nTILT=NONE\n1 -1 1 %u %u %d 2 %.9g %.9g %.9g\n1 1 %.9g\n",
        l->name, l->vertical_count, l->horizontal_count, type, l->width, l->length, l->height,
        l->watts);
    for (uint32_t k = 0; k < l->vertical_count; k++)
        fprintf(to, "%.9g\n", (double)l->vertical[k]);
    for (uint32_t k = 0; k < l->horizontal_count; k++)
        fprintf(to, "%.9g\n", (double)l->horizontal[k]);
    for (size_t k = 0; k < count; k++)
        fprintf(to, "%.9g\n", (double)l->intensity[k]);
    bool good = fclose(to) == 0;
    if (good) *text = rsv_copy_string(context, made);
    free(made);
    return *text ? RSV_OK : RSV_ERROR_MEMORY;
}
