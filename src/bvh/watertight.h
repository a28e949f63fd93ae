/// Ray against triangle without gaps along shared edges: Woop, Benthin and Wald, "Watertight Ray/Triangle
/// Intersection" (2013).
#ifndef RSV_WATERTIGHT_H
#define RSV_WATERTIGHT_H

#include "../core/vec.h"
#include "bvh.h"
#include "resolvent/trace.h"

/// The shear that turns a ray's direction into the unit vector of its main axis.
typedef struct rsv_shear {
    int axis;      ///< axis of the largest component: 0, 1 or 2
    float x, y, z; ///< x and y: of the axes after the main one
} rsv_shear;

/// The vector with its axes turned so that axis `last` comes last.
RSV_INLINE rsv_vec3 rsv_turn_axes(rsv_vec3 a, int last)
{
    return last == 2 ? a : last == 0 ? v3(a.y, a.z, a.x) : v3(a.z, a.x, a.y);
}

RSV_INLINE rsv_shear rsv_shear_of(rsv_vec3 direction)
{
    float x = fabsf(direction.x), y = fabsf(direction.y), z = fabsf(direction.z);
    rsv_shear shear;
    shear.axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    rsv_vec3 d = rsv_turn_axes(direction, shear.axis);
    shear.z = 1 / d.z;
    shear.x = d.x * shear.z;
    shear.y = d.y * shear.z;
    return shear;
}

/// a b - c d, with each product rounded separately, even if the compiler contracts expressions. The result is the exact
/// opposite for the other triangle at an edge.
RSV_INLINE float rsv_cross_difference(float a, float b, float c, float d)
{
#if defined(__CUDA_ARCH__)
    return __fsub_rn(__fmul_rn(a, b), __fmul_rn(c, d));
#else
    return a * b - c * d;
#endif
}

/// A corner seen from the ray: x and y across it, z along the main axis.
RSV_INLINE rsv_vec3 rsv_sheared(const rsv_shear *shear, rsv_vec3 origin, rsv_vec3 corner)
{
    rsv_vec3 p = rsv_turn_axes(v3_sub(corner, origin), shear->axis);
    return v3(rsv_cross_difference(p.x, 1, shear->x, p.z),
        rsv_cross_difference(p.y, 1, shear->y, p.z), p.z);
}

/// Twice the area of the triangle that the edge p to q makes with the ray, to the last place where that says nothing.
RSV_INLINE float rsv_edge_side(rsv_vec3 p, rsv_vec3 q)
{
    float side = rsv_cross_difference(p.x, q.y, p.y, q.x);
    return side != 0 ? side : (float)((double)p.x * q.y - (double)p.y * q.x);
}

/// Whether the ray meets the triangle at a distance in (0, t_max). @param hit out: t, u and v
RSV_INLINE bool rsv_meets_triangle(const rsv_shear *shear, rsv_vec3 origin,
    const rsv_bvh_triangle *triangle, float t_max, rsv_hit *hit)
{
    rsv_vec3 a = rsv_sheared(shear, origin, triangle->a),
             b = rsv_sheared(shear, origin, triangle->b),
             c = rsv_sheared(shear, origin, triangle->c);
    float of_a = rsv_edge_side(c, b), of_b = rsv_edge_side(a, c), of_c = rsv_edge_side(b, a);
    if ((of_a < 0 || of_b < 0 || of_c < 0) && (of_a > 0 || of_b > 0 || of_c > 0)) return false;
    float sum = of_a + of_b + of_c;
    if (sum == 0) return false; // seen from its edge, or no area
    float t = (of_a * a.z + of_b * b.z + of_c * c.z) * shear->z / sum;
    if (!(t > 0 && t < t_max)) return false;
    hit->t = t;
    hit->u = of_b / sum;
    hit->v = of_c / sum;
    return true;
}

#endif
