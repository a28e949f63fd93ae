/// A surface at the point where light meets it: position, normals, scattering.
///
/// `width` is the size of the patch over which textures are averaged, in metres (scene/material_at.h): 0 = the point
/// itself, the size of a pixel for cameras, more for gather rays, each of which represents a cone of directions.
///
/// Inline functions are also for device code.
#ifndef RSV_SURFACE_H
#define RSV_SURFACE_H

#include "../bsdf/bsdf.h"
#include "../core/vec.h"
#include "../scene/twins.h"

/// A point of the surface with its two normals, on the side of its face.
typedef struct rsv_surface_point {
    rsv_vec3 position;
    rsv_vec3 normal;    ///< unit shading normal
    rsv_vec3 geometric; ///< unit geometric normal
    float extent;       ///< for rsv_offset_origin
    rsv_vec3 horizon;   ///< unit normal that decides which light is above: geometric, except where lifted
    rsv_vec3 lift; ///< to the curved surface that the triangle stands for (lift.h); zero = none
} rsv_surface_point;

/// The point of a triangle with these corners and normals at them.
RSV_INLINE rsv_surface_point rsv_surface_point_of(
    const rsv_vec3 corner[3], const rsv_vec3 normal[3], float u, float v, bool back)
{
    rsv_vec3 a = corner[0], b = corner[1], c = corner[2];
    rsv_surface_point point;
    point.position = v3_barycentric(a, b, c, u, v);
    point.geometric = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    point.normal = v3_normalize(v3_barycentric(normal[0], normal[1], normal[2], u, v));
    if (v3_dot(point.normal, point.geometric) <= 0) point.normal = point.geometric;
    if (back) {
        point.geometric = v3_neg(point.geometric);
        point.normal = v3_neg(point.normal);
    }
    point.horizon = point.geometric;
    point.lift = v3(0, 0, 0);
    point.extent = f_max(v3_max_abs(a), f_max(v3_max_abs(b), v3_max_abs(c)));
    return point;
}

/// The point with its interpolated normal, normal maps left out.
RSV_INLINE rsv_surface_point rsv_surface_point_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back)
{
    const uint32_t *at = scene->triangle[triangle];
    rsv_vec3 corner[3] = { scene->position[at[0]], scene->position[at[1]], scene->position[at[2]] };
    rsv_vec3 normal[3] = { scene->normal[at[0]], scene->normal[at[1]], scene->normal[at[2]] };
    rsv_surface_point point = rsv_surface_point_of(corner, normal, u, v, back);
    point.extent = f_max(point.extent, rsv_twins_extent(scene, triangle));
    return point;
}

/// The point with its normal map, for viewing and for elements.
RSV_SHARED rsv_surface_point rsv_surface_point_seen(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back, float width);

/// Whether light from `direction` is above the surface by both of its normals.
RSV_INLINE bool rsv_surface_faces(const rsv_surface_point *point, rsv_vec3 direction)
{
    return v3_dot(point->normal, direction) > 0 && v3_dot(point->horizon, direction) > 0;
}

/// Area of a triangle of the scene, m2.
float rsv_triangle_area(const rsv_scene_view *scene, uint32_t triangle);

/// Scattering common to all surfaces of a material: its constants if it is plain, otherwise its mean, with `lambert`
/// only if that is true everywhere.
rsv_bsdf rsv_surface_common_bsdf(const rsv_scene_view *scene, uint32_t material);

/// A place on a triangle, and the width over which textures are averaged there, metres.
typedef struct rsv_footprint {
    uint32_t triangle;
    float u, v, width;
    rsv_channel channel; ///< of light that smooth bodies disperse
} rsv_footprint;

/// Scattering at the surface point.
/// @param common [material_count] from rsv_surface_common_bsdf
/// @param storage used if the material varies
/// @return an entry of `common` for plain materials, at no cost; otherwise `storage`
RSV_SHARED const rsv_bsdf *rsv_surface_bsdf(
    const rsv_scene_view *scene, const rsv_bsdf *common, rsv_footprint at, rsv_bsdf *storage);

/// The same for the diffuse lobe only (rsv_bsdf_vary_entry).
RSV_SHARED const rsv_bsdf *rsv_surface_entry_bsdf(
    const rsv_scene_view *scene, const rsv_bsdf *common, rsv_footprint at, rsv_bsdf *storage);

#if defined(RSV_DEVICE_CODE)
#include "surface_body.h"
#endif

#endif
