/// Uniform sampling of spherical triangles, in half-angles: no inverse cosine, no interior angle,
/// hence no loss of digits where the triangle is small or nearly a hemisphere. For device code too.
#ifndef RSV_SPHERICAL_TRIANGLE_H
#define RSV_SPHERICAL_TRIANGLE_H

#include "double3.h"

/// A triangle as a unit-sphere triangle about a point that is not in its plane.
typedef struct rsv_spherical_triangle {
    rsv_double3 corner[3]; ///< unit
    double solid_angle;    ///< sr, 0..2 pi
} rsv_spherical_triangle;

/// @param corner [3], relative to the point
RSV_INLINE rsv_spherical_triangle rsv_spherical_triangle_from(const rsv_double3 *corner)
{
    rsv_spherical_triangle triangle;
    double length[3];
    for (int i = 0; i < 3; i++) {
        length[i] = d3_length(corner[i]);
        triangle.corner[i] = d3_normalize(corner[i]);
    }
    // tan(solid_angle / 2), Van Oosterom and Strackee 1983; the volume from the edges, as small
    // triangles would cancel otherwise
    rsv_double3 edge1 = d3_sub(corner[1], corner[0]), edge2 = d3_sub(corner[2], corner[0]);
    double volume = fabs(d3_dot(corner[0], d3_cross(edge1, edge2)));
    double cosines = length[0] * length[1] * length[2] + d3_dot(corner[0], corner[1]) * length[2] +
                     d3_dot(corner[1], corner[2]) * length[0] +
                     d3_dot(corner[2], corner[0]) * length[1];
    triangle.solid_angle = 2 * atan2(volume, cosines);
    return triangle;
}

/// The point c on the great circle from corner 0 through corner 2 that makes (corner 0, corner 1,
/// c) a triangle of the given solid angle. With c = cos(phi) a + sin(phi) w, w the tangent at a,
///
///     tan(solid_angle / 2) = tan(phi/2) |a, b, w| / (1 + a.b + tan(phi/2) b.w)
///
/// which is linear in the tangent of the half-angle.
RSV_INLINE rsv_double3 rsv_split_point(const rsv_spherical_triangle *triangle, double solid_angle)
{
    rsv_double3 a = triangle->corner[0], b = triangle->corner[1], c = triangle->corner[2];
    rsv_double3 tangent = d3_normalize(d3_mad(c, -d3_dot(a, c), a));
    double volume = fabs(d3_dot(tangent, d3_cross(a, b)));
    double half_cos = cos(0.5 * solid_angle) * volume - sin(0.5 * solid_angle) * d3_dot(b, tangent);
    double half_sin = sin(0.5 * solid_angle) * (1 + d3_dot(a, b));
    double norm = half_cos * half_cos + half_sin * half_sin;
    if (!(norm > 0)) return c;
    double cos_phi = (half_cos * half_cos - half_sin * half_sin) / norm;
    double sin_phi = 2 * half_cos * half_sin / norm;
    return d3_mad(d3_scale(a, cos_phi), sin_phi, tangent);
}

/// Uniform direction in the triangle: the first coordinate chooses a sub-triangle of u1 times the
/// solid angle, the second a point on its far side (Arvo 1995).
RSV_INLINE rsv_double3 rsv_spherical_triangle_sample(
    const rsv_spherical_triangle *triangle, double u1, double u2)
{
    rsv_double3 b = triangle->corner[1], c = rsv_split_point(triangle, u1 * triangle->solid_angle);
    rsv_double3 chord = d3_sub(c, b);
    double depth = 0.5 * d3_dot(chord, chord); // 1 - b.c without cancellation
    rsv_double3 tangent = d3_normalize(d3_mad(chord, depth, b));
    double height = u2 * depth; // uniform in the cosine about b
    return d3_mad(d3_scale(b, 1 - height), sqrt(fmax(height * (2 - height), 0.0)), tangent);
}

#endif
