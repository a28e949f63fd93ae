/// Double-precision vectors for geometry relative to a receiver. The inputs are floats, so differences of coordinates
/// are exact, and later cancellation leaves enough digits.
#ifndef RSV_DOUBLE3_H
#define RSV_DOUBLE3_H

#include "../core/vec.h"

typedef struct rsv_double3 {
    double x, y, z;
} rsv_double3;

RSV_INLINE rsv_double3 d3(double x, double y, double z)
{
    rsv_double3 r = { x, y, z };
    return r;
}
RSV_INLINE rsv_double3 d3_from(rsv_vec3 a) { return d3(a.x, a.y, a.z); }
/// to - from
RSV_INLINE rsv_double3 d3_between(rsv_vec3 from, rsv_vec3 to)
{
    return d3((double)to.x - from.x, (double)to.y - from.y, (double)to.z - from.z);
}
RSV_INLINE rsv_double3 d3_sub(rsv_double3 a, rsv_double3 b)
{
    return d3(a.x - b.x, a.y - b.y, a.z - b.z);
}
RSV_INLINE rsv_double3 d3_scale(rsv_double3 a, double s) { return d3(a.x * s, a.y * s, a.z * s); }
/// a + s b
RSV_INLINE rsv_double3 d3_mad(rsv_double3 a, double s, rsv_double3 b)
{
    return d3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
RSV_INLINE double d3_dot(rsv_double3 a, rsv_double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
RSV_INLINE rsv_double3 d3_cross(rsv_double3 a, rsv_double3 b)
{
    return d3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
RSV_INLINE double d3_length(rsv_double3 a) { return sqrt(d3_dot(a, a)); }
/// a / |a|; the zero vector stays zero.
RSV_INLINE rsv_double3 d3_normalize(rsv_double3 a)
{
    double length = d3_length(a);
    return length > 0 ? d3_scale(a, 1 / length) : a;
}
RSV_INLINE rsv_vec3 d3_to_float(rsv_double3 a) { return v3((float)a.x, (float)a.y, (float)a.z); }

#endif
