/// What a textured material is at a point, and what it is on the whole.
///
/// `width` says how finely a point is looked at: the edge of the patch, in metres, that the answer is the mean
/// of. 0 = the point itself; INFINITY = all of each texture. Textures are looked up on the level of their pyramid
/// whose texels are that large.
#ifndef RSV_MATERIAL_AT_H
#define RSV_MATERIAL_AT_H

#include "../core/vec.h"
#include "resolvent/scene.h"

/// Flags of rsv_scene_view.material_varies.
#define RSV_VARIES_BY_TEXTURE 1
#define RSV_VARIES_BY_COLOR 2   ///< of vertices
#define RSV_VARIES_BY_OPACITY 4 ///< of vertices

/// The material of a triangle with its textures and the colours of its vertices multiplied in.
RSV_SHARED rsv_material rsv_material_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width);

/// The material with the mean of each texture multiplied in. A property that is 0 here is 0 everywhere.
rsv_material rsv_material_mean(const rsv_scene_view *scene, uint32_t material);

/// The first material that is cut out where its texture says so (alpha_cutoff); NULL = there is none.
const rsv_material *rsv_find_cut_out(const rsv_scene_view *scene);

/// Whether a ray that meets the triangle there goes on because the surface is cut out.
RSV_SHARED bool rsv_is_cut_out(const rsv_scene_view *scene, uint32_t triangle, float u, float v);

/// The shading normal that a normal map makes of the interpolated one (unit, on the front side); the same one if
/// there is no map.
RSV_SHARED rsv_vec3 rsv_mapped_normal(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width, rsv_vec3 normal);

#if defined(RSV_DEVICE_CODE)
#include "material_at_body.h"
#endif

#endif
