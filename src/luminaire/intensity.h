/// Intensities between the angles of a luminaire, by its symmetry. For device code too.
#ifndef RSV_LUMINAIRE_INTENSITY_H
#define RSV_LUMINAIRE_INTENSITY_H

#include "../core/vec.h"
#include "resolvent/luminaire.h"

#define RSV_LUMINAIRE_DEGREES 57.295779513082321
#define RSV_LUMINAIRE_SLACK 1e-3 ///< degrees that a file's last angle may fall short

/// The interval of ascending angles that holds a value, and where in it. @return false beyond them
RSV_INLINE bool rsv_luminaire_interval(
    const float *angle, uint32_t count, double value, uint32_t *index, double *within)
{
    if (value < (double)angle[0] - RSV_LUMINAIRE_SLACK ||
        value > (double)angle[count - 1] + RSV_LUMINAIRE_SLACK)
        return false;
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
    *within = step > 0 ? fmin(fmax((value - (double)angle[low]) / step, 0.0), 1.0) : 0;
    return true;
}

/// Maps a horizontal angle of type C to the range stored in the file.
RSV_INLINE double rsv_luminaire_fold_c(const rsv_luminaire *l, double c)
{
    double first = (double)l->horizontal[0], last = (double)l->horizontal[l->horizontal_count - 1];
    double span = last - first;
    if (l->horizontal_count == 1) return first;
    c = fmod(fmod(c - first, 360.0) + 360, 360.0);          // from the first plane on
    if (span > 180 + RSV_LUMINAIRE_SLACK) return first + c; // planes all around
    if (c > 180) c = 360 - c;                               // mirrored at the first plane
    if (span > 90 + RSV_LUMINAIRE_SLACK) return first + c;
    return first + (c > 90 ? 180 - c : c); // at the second one as well
}

/// Of types A and B, which may state one half of the angles.
RSV_INLINE double rsv_luminaire_fold_half(const float *angle, double value)
{
    return angle[0] >= 0 ? fabs(value) : value;
}

/// Intensity in a direction by its parts along C = 0, along C = 90 (up, of types A and B) and along the axis.
RSV_INLINE double rsv_luminaire_towards(const rsv_luminaire *l, double side, double up, double axis)
{
    double vertical, horizontal, v, h;
    uint32_t i, j;
    if (l->type == RSV_PHOTOMETRY_C) {
        vertical = atan2(sqrt(side * side + up * up), axis) * RSV_LUMINAIRE_DEGREES;
        horizontal = rsv_luminaire_fold_c(l, atan2(up, side) * RSV_LUMINAIRE_DEGREES);
    } else {
        bool floodlight = l->type == RSV_PHOTOMETRY_B;
        double pole = floodlight ? side : up, turned = floodlight ? up : side;
        double latitude = atan2(pole, sqrt(turned * turned + axis * axis)) * RSV_LUMINAIRE_DEGREES;
        double turn = atan2(turned, axis) * RSV_LUMINAIRE_DEGREES;
        vertical = rsv_luminaire_fold_half(l->vertical, floodlight ? turn : latitude);
        horizontal = rsv_luminaire_fold_half(l->horizontal, floodlight ? latitude : turn);
    }
    if (!rsv_luminaire_interval(l->vertical, l->vertical_count, vertical, &i, &v) ||
        !rsv_luminaire_interval(l->horizontal, l->horizontal_count, horizontal, &j, &h))
        return 0;
    const float *near = l->intensity + (size_t)j * l->vertical_count + i;
    const float *far = near + (j + 1 < l->horizontal_count ? l->vertical_count : 0);
    uint32_t next = i + 1 < l->vertical_count;
    return (1 - h) * ((1 - v) * (double)near[0] + v * (double)near[next]) +
           h * ((1 - v) * (double)far[0] + v * (double)far[next]);
}

#endif
