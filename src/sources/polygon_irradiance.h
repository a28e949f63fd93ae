/// Irradiance from a uniform polygon: Lambert's edge sum over the part above the receiver's
/// horizon. For device code too.
#ifndef RSV_POLYGON_IRRADIANCE_H
#define RSV_POLYGON_IRRADIANCE_H

#include "double3.h"

#include <float.h>

#define RSV_POLYGON_CORNERS 4

/// Largest height above a plane due to rounding of the coordinates: a few units in the last place of the largest one.
RSV_INLINE double rsv_rounding_height(const rsv_vec3 *corner, int corner_count, rsv_vec3 p)
{
    float largest = v3_max_abs(p);
    for (int i = 0; i < corner_count; i++)
        largest = f_max(largest, v3_max_abs(corner[i]));
    return 0x1p-21 * largest;
}

/// Sutherland and Hodgman's clip of a convex polygon against height >= 0; returns the corners left.
RSV_INLINE int rsv_clip_to_horizon(
    const rsv_double3 *corner, int count, rsv_double3 n, rsv_double3 *clipped)
{
    int clipped_count = 0;
    rsv_double3 previous = corner[count - 1];
    double previous_height = d3_dot(n, previous);
    for (int i = 0; i < count; i++) {
        double height = d3_dot(n, corner[i]);
        if ((height > 0) != (previous_height > 0)) {
            double t = previous_height / (previous_height - height);
            clipped[clipped_count++] = d3_mad(previous, t, d3_sub(corner[i], previous));
        }
        if (height > 0) clipped[clipped_count++] = corner[i];
        previous = corner[i];
        previous_height = height;
    }
    return clipped_count;
}

/// theta / sin(theta) from x = sin^2(theta / 2): analytic, so that small angles keep their digits.
/// Chebyshev interpolant of asin(sqrt(x)) / sqrt(x (1 - x)) on [0, 1/2], relative error 1.3e-8.
RSV_INLINE double rsv_angle_over_sine(double x)
{
    const double coefficient[] = { 0.9999999877216724, 0.6666714347428405, 0.5330295626025757,
        0.4645923161896395, 0.3145556741415163, 1.0091783377697539, -2.3100163144858925,
        6.85034163169621, -8.694211360940244, 5.872689042007551 };
    double y = x <= 0.5 ? x : 1 - x, sum = coefficient[9];
    for (int i = 8; i >= 0; i--)
        sum = sum * y + coefficient[i];
    return x <= 0.5 ? sum : 0.5 * M_PI / sqrt(x * y > DBL_MIN ? x * y : DBL_MIN) - sum;
}

/// Twice one edge's term: the angle between the unit vectors a and b times the cosine between n and
/// the normal of their plane. Made from their difference, which keeps the digits of short edges.
RSV_INLINE double rsv_edge_term(rsv_double3 a, rsv_double3 b, rsv_double3 n)
{
    rsv_double3 chord = d3_sub(b, a);
    double x = 0.25 * d3_dot(chord, chord);
    return rsv_angle_over_sine(x < 1 ? x : 1) * d3_dot(n, d3_cross(a, chord));
}

/// The product of the diagonals is twice the area vector; a triangle is a quadrilateral that ends
/// where it began.
RSV_INLINE bool rsv_is_in_plane(const rsv_double3 *corner, int count, double tolerance)
{
    rsv_double3 normal =
        d3_cross(d3_sub(corner[2], corner[0]), d3_sub(corner[3 % count], corner[1]));
    return fabs(d3_dot(normal, corner[0])) <= tolerance * d3_length(normal);
}

/// Irradiance at `p` with unit normal `n` from a uniform polygon emitter without occlusion, divided
/// by its radiance: int cos+ dw over the part above the horizon (Lambert's formula after clipping).
/// The caller checks that p is on the emitting side. Exact to float rounding; robust for p in the
/// polygon's plane.
/// @param corner polygon, 3 <= corner_count <= RSV_POLYGON_CORNERS
RSV_INLINE float rsv_polygon_irradiance(
    const rsv_vec3 *corner, int corner_count, rsv_vec3 p, rsv_vec3 n)
{
    rsv_double3 local[RSV_POLYGON_CORNERS], visible[2 * RSV_POLYGON_CORNERS], normal = d3_from(n);
    for (int i = 0; i < corner_count; i++)
        local[i] = d3_between(p, corner[i]);
    if (rsv_is_in_plane(local, corner_count, rsv_rounding_height(corner, corner_count, p)))
        return 0;
    int count = rsv_clip_to_horizon(local, corner_count, normal, visible);
    for (int i = 0; i < count; i++)
        visible[i] = d3_normalize(visible[i]);
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += rsv_edge_term(visible[i], visible[i + 1 < count ? i + 1 : 0], normal);
    return (float)(0.5 * fabs(sum));
}

#endif
