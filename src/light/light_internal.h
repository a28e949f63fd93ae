/// Double-precision vectors for geometry seen from a receiver: the inputs are floats, so
/// differences of coordinates are exact and what cancels later has digits to spare.
#ifndef RSV_LIGHT_INTERNAL_H
#define RSV_LIGHT_INTERNAL_H

#include "light.h"

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

/// Heights above a plane that rounding of the coordinates alone can produce: a few units in the
/// last place of the largest one.
RSV_INLINE double rsv_rounding_height(const rsv_vec3 *corner, int corner_count, rsv_vec3 p)
{
    float largest = v3_max_abs(p);
    for (int i = 0; i < corner_count; i++)
        largest = f_max(largest, v3_max_abs(corner[i]));
    return 0x1p-21 * largest;
}

/// Whether `point` is above a side that emits, by more than the rounding of its coordinates.
bool rsv_emitter_faces(const rsv_emitter *emitter, rsv_vec3 point);

/// Whether a surface of this material is brighter here than there.
bool rsv_emission_varies(const rsv_material *material);

/// One of the 4^level cells of a triangle, with its mean radiance; all of its group is left to be set.
rsv_emitter rsv_emitter_create(
    const rsv_scene_view *scene, const rsv_bsdf *bsdf, uint32_t triangle, int level, uint32_t cell);

/// Puts it where its triangle is now.
void rsv_emitter_follow(const rsv_scene_view *scene, rsv_emitter *emitter);

/// Gives it the radiance that its material has now.
void rsv_emitter_set_strength(
    const rsv_scene_view *scene, const rsv_bsdf *material, rsv_emitter *emitter);

/// Builds the trees, where there are enough lights for them; earlier ones are felled.
rsv_status rsv_lights_plant_trees(rsv_lights *lights);

/// Sets `share` and `gathered` of every group.
void rsv_lights_choose_gathered(rsv_lights *lights);

/// A triangle as a unit-sphere triangle about a point that is not in its plane.
typedef struct rsv_spherical_triangle {
    rsv_double3 corner[3]; ///< unit
    double solid_angle;    ///< sr, 0..2 pi
} rsv_spherical_triangle;

/// @param corner [3], relative to the point
rsv_spherical_triangle rsv_spherical_triangle_from(const rsv_double3 *corner);

/// Uniform direction in the triangle: the first coordinate chooses a sub-triangle of u1 times the
/// solid angle, the second a point on its far side (Arvo 1995).
rsv_double3 rsv_spherical_triangle_sample(
    const rsv_spherical_triangle *triangle, double u1, double u2);

#endif
