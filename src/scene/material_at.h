/// A textured material at a point, or its mean.
///
/// `width` is the size of the patch to average over, in metres: 0 = the point itself; INFINITY = the whole of each
/// texture. Textures are looked up in the mip level whose texels have that size.
#ifndef RSV_MATERIAL_AT_H
#define RSV_MATERIAL_AT_H

#include "../core/vec.h"
#include "coat_normal.h"
#include "resolvent/scene.h"

/// Flags of rsv_scene_view.material_varies.
#define RSV_VARIES_BY_TEXTURE 1
#define RSV_VARIES_BY_COLOR 2   ///< of vertices
#define RSV_VARIES_BY_OPACITY 4 ///< of vertices
#define RSV_VARIES_BY_TANGENT 8 ///< anisotropic

/// The material of a triangle with its textures and the colours of its vertices multiplied in.
RSV_SHARED rsv_material rsv_material_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width);

/// Only its base colour, without vertex colours.
RSV_SHARED rsv_rgb rsv_base_color_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width);

/// The material with the mean of each texture multiplied in. A property that is 0 here is 0 everywhere.
rsv_material rsv_material_mean(const rsv_scene_view *scene, uint32_t material);

/// The first material that is cut out where its texture says so (alpha_cutoff); NULL = there is none.
const rsv_material *rsv_find_cut_out(const rsv_scene_view *scene);

/// Keeps surfaces whose opacity equals the cutoff, in spite of the rounding of products and interpolation.
#define RSV_CUTOFF_SHARE (1 - 1e-6f)

/// Whether a ray that meets the triangle there goes on because the surface is cut out.
RSV_SHARED bool rsv_is_cut_out(const rsv_scene_view *scene, uint32_t triangle, float u, float v);

/// Whether surfaces of a material transmit part of the light straight through: alpha-blended ones, except on solid
/// bodies.
RSV_INLINE bool rsv_is_blended(const rsv_scene_view *scene, uint32_t material)
{
    const rsv_material *m = &scene->material[material];
    bool body = m->thickness > 0 && m->transmission > 0 && m->metallic < 1 && !m->unlit;
    if (m->alpha_cutoff > 0 || body) return false;
    if (m->opacity < 1 || (scene->material_varies[material] & RSV_VARIES_BY_OPACITY)) return true;
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == RSV_TEXTURE_OPACITY) return true;
    return false;
}

/// Whether a scene has such materials.
bool rsv_find_blended(const rsv_scene_view *scene);

/// How much of the light on a triangle does not pass straight on there; 1 = it is not blended, whether cut out or not.
RSV_SHARED float rsv_opacity_at(const rsv_scene_view *scene, uint32_t triangle, float u, float v);

/// About how much of a patch around a point is left where a surface is cut out; 1 = it is not.
RSV_SHARED float rsv_left_of_cut_out(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width);

/// The shading normal that a normal map makes of the interpolated one (unit, on the front side); the same one if
/// there is no map.
RSV_SHARED rsv_vec3 rsv_mapped_normal(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width, rsv_vec3 normal);

/// The same of the clear coat, whatever the map below it.
RSV_SHARED rsv_vec3 rsv_mapped_coat_normal(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width, rsv_vec3 normal);

/// The texture whose coordinates tangents follow: the normal map's, or else the anisotropy's, the clear coat's, or set 0 as
/// it stands.
RSV_INLINE rsv_texture_ref rsv_tangent_ref(const rsv_material *m)
{
    rsv_texture_ref ref = { RSV_TEXTURE_NORMAL, 0, 0, { { 1, 0, 0 }, { 0, 1, 0 } }, 1 };
    const rsv_texture_ref *found = rsv_find_texture(m, RSV_TEXTURE_NORMAL);
    if (!found) found = rsv_find_texture(m, RSV_TEXTURE_ANISOTROPY);
    if (!found) found = rsv_find_texture(m, RSV_TEXTURE_CLEARCOAT_NORMAL);
    return found ? *found : ref;
}

/// Direction in which highlights of metal are stretched: the tangent, rotated by `rotation` radians; unit, or zero if
/// there are neither texture coordinates nor tangents.
RSV_SHARED rsv_vec3 rsv_brush_direction(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float rotation);

#if defined(RSV_DEVICE_CODE)
#include "material_at_body.h"
#endif

#endif
