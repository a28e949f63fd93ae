/// Materials at points of their surfaces (material_at.h).
#ifndef RSV_MATERIAL_AT_BODY_H
#define RSV_MATERIAL_AT_BODY_H

#include "material_at.h"
#include "material_fields.h"
#include "tangent.h"
#include "texture.h"
#include "texture_triangle.h"

/// Level of the pyramid whose texels are about `width` metres large on the triangle.
RSV_INLINE float rsv_texture_level_for(const rsv_scene_view *scene, const rsv_texture *texture,
    const rsv_texture_triangle *t, const uint32_t *corner, float width)
{
    if (!(width > 0)) return 0;
    if (width == INFINITY) return RSV_TEXTURE_MAX_LEVELS;
    rsv_vec3 edge1, edge2;
    rsv_triangle_edges(scene, corner, &edge1, &edge2);
    float texels = fabsf(rsv_texture_area(t)) * (float)texture->level[0].width *
                   (float)texture->level[0].height;
    float texels_per_area = texels / v3_length(v3_cross(edge1, edge2));
    return 0.5f * log2f(width * width * texels_per_area);
}

RSV_INLINE rsv_texel rsv_texture_at(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    uint32_t triangle, float u, float v, float width)
{
    const rsv_texture *texture = &scene->texture[ref->texture];
    if (!scene->uv[ref->uv_set]) return rsv_texture_mean(texture);
    const uint32_t *corner = scene->triangle[triangle];
    rsv_texture_triangle t = rsv_texture_triangle_of(scene, ref, corner);
    float level = rsv_texture_level_for(scene, texture, &t, corner, width);
    return rsv_texture_lookup(
        texture, t.u + u * t.du[0] + v * t.du[1], t.v + u * t.dv[0] + v * t.dv[1], level);
}

#define RSV_TIMES_r(value) ((value)*texel.r)
#define RSV_TIMES_g(value) ((value)*texel.g)
#define RSV_TIMES_a(value) ((value)*texel.a)
#define RSV_TIMES_rgb(value) rgb_mul(value, color)

RSV_INLINE void rsv_material_multiply(rsv_material *m, rsv_texture_role role, rsv_texel texel)
{
    rsv_rgb color = rgb(texel.r, texel.g, texel.b);
    switch (role) {
    case RSV_TEXTURE_BASE_COLOR:
        m->base_color = rgb_mul(m->base_color, color);
        break;
    case RSV_TEXTURE_OPACITY:
        m->opacity *= texel.a;
        break;
    case RSV_TEXTURE_METALLIC_ROUGHNESS:
        m->metallic *= texel.b;
        m->roughness *= texel.g;
        break;
    case RSV_TEXTURE_IRIDESCENCE_THICKNESS:
        m->iridescence_thickness_max =
            m->iridescence_thickness_min +
            texel.g * (m->iridescence_thickness_max - m->iridescence_thickness_min);
        break;
    case RSV_TEXTURE_ANISOTROPY:
        m->anisotropy *= texel.b;
        m->anisotropy_rotation += atan2f(2 * texel.g - 1, 2 * texel.r - 1);
        break;
    case RSV_TEXTURE_EMISSION:
        m->emission = rgb_mul(m->emission, color);
        break;
#define TEXTURE(role, field, channel, srgb, extension, key)                                        \
    case RSV_TEXTURE_##role:                                                                       \
        m->field = RSV_TIMES_##channel(m->field);                                                  \
        break;
        RSV_MATERIAL_TEXTURES(TEXTURE)
#undef TEXTURE
    default: // normals are no factor
        break;
    }
}

RSV_INLINE float rsv_vertex_color(
    const rsv_scene_view *scene, const uint32_t *corner, float u, float v, int channel)
{
    const float(*c)[4] = scene->color;
    return (1 - u - v) * c[corner[0]][channel] + u * c[corner[1]][channel] +
           v * c[corner[2]][channel];
}

RSV_SHARED rsv_material rsv_material_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    uint32_t index = scene->triangle_material[triangle];
    rsv_material m = scene->material[index];
    for (size_t i = 0; i < m.texture_count; i++)
        if (m.textures[i].role != RSV_TEXTURE_NORMAL &&
            m.textures[i].role != RSV_TEXTURE_CLEARCOAT_NORMAL)
            rsv_material_multiply(&m, m.textures[i].role,
                rsv_texture_at(scene, &m.textures[i], triangle, u, v, width));
    if (scene->material_varies[index] & (RSV_VARIES_BY_COLOR | RSV_VARIES_BY_OPACITY)) {
        const uint32_t *corner = scene->triangle[triangle];
        rsv_rgb color = rgb(rsv_vertex_color(scene, corner, u, v, 0),
            rsv_vertex_color(scene, corner, u, v, 1), rsv_vertex_color(scene, corner, u, v, 2));
        m.base_color = rgb_mul(m.base_color, color);
        m.opacity *= rsv_vertex_color(scene, corner, u, v, 3);
    }
    if (m.alpha_cutoff > 0) m.opacity = 1; // rays only hit the remaining parts of a cut-out surface
    return m;
}

RSV_SHARED rsv_rgb rsv_base_color_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    const rsv_material *m = &scene->material[scene->triangle_material[triangle]];
    rsv_rgb color = m->base_color;
    for (size_t i = 0; i < m->texture_count; i++) {
        if (m->textures[i].role != RSV_TEXTURE_BASE_COLOR) continue;
        rsv_texel texel = rsv_texture_at(scene, &m->textures[i], triangle, u, v, width);
        color = rgb_mul(color, rgb(texel.r, texel.g, texel.b));
    }
    return color;
}

/// The opacity, multiplied by textures and vertex colours.
RSV_INLINE float rsv_varied_opacity(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    uint32_t index = scene->triangle_material[triangle];
    const rsv_material *m = &scene->material[index];
    float opacity = m->opacity;
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == RSV_TEXTURE_OPACITY)
            opacity *= rsv_texture_at(scene, &m->textures[i], triangle, u, v, width).a;
    if (scene->material_varies[index] & RSV_VARIES_BY_OPACITY)
        opacity *= rsv_vertex_color(scene, scene->triangle[triangle], u, v, 3);
    return f_min(f_max(opacity, 0), 1);
}

RSV_SHARED bool rsv_is_cut_out(const rsv_scene_view *scene, uint32_t triangle, float u, float v)
{
    const rsv_material *m = &scene->material[scene->triangle_material[triangle]];
    return m->alpha_cutoff > 0 &&
           rsv_varied_opacity(scene, triangle, u, v, 0) < RSV_CUTOFF_SHARE * m->alpha_cutoff;
}

RSV_SHARED float rsv_opacity_at(const rsv_scene_view *scene, uint32_t triangle, float u, float v)
{
    if (!rsv_is_blended(scene, scene->triangle_material[triangle])) return 1;
    return rsv_varied_opacity(scene, triangle, u, v, 0);
}

RSV_SHARED float rsv_left_of_cut_out(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    const rsv_material *m = &scene->material[scene->triangle_material[triangle]];
    return m->alpha_cutoff > 0 ? rsv_varied_opacity(scene, triangle, u, v, width) : 1;
}

// ---- normal maps --------------------------------------------------------------------------------

/// @param normal the interpolated one
RSV_INLINE rsv_vec3 rsv_normal_by_map(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    uint32_t triangle, const float at[2], float width, rsv_vec3 normal)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 frame[2] = { normal };
    if (!ref || !rsv_tangent_frame(scene, ref, corner, at, frame)) return normal;
    rsv_texel texel = rsv_texture_at(scene, ref, triangle, at[0], at[1], width);
    float x = ref->scale * (2 * texel.r - 1), y = ref->scale * (2 * texel.g - 1);
    rsv_vec3 mapped = v3_mad(v3_mad(v3_scale(normal, 2 * texel.b - 1), x, frame[0]), y, frame[1]);
    return v3_length(mapped) > 0 ? v3_normalize(mapped) : normal;
}

RSV_SHARED rsv_vec3 rsv_mapped_normal(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width, rsv_vec3 normal)
{
    const rsv_material *m = &scene->material[scene->triangle_material[triangle]];
    const float at[2] = { u, v };
    return rsv_normal_by_map(
        scene, rsv_find_texture(m, RSV_TEXTURE_NORMAL), triangle, at, width, normal);
}

RSV_SHARED rsv_vec3 rsv_mapped_coat_normal(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width, rsv_vec3 normal)
{
    const rsv_material *m = &scene->material[scene->triangle_material[triangle]];
    const float at[2] = { u, v };
    return rsv_normal_by_map(
        scene, rsv_find_texture(m, RSV_TEXTURE_CLEARCOAT_NORMAL), triangle, at, width, normal);
}

// ---- brushed metal ------------------------------------------------------------------------------

RSV_SHARED rsv_vec3 rsv_brush_direction(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float rotation)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_texture_ref ref = rsv_tangent_ref(&scene->material[scene->triangle_material[triangle]]);
    const rsv_vec3 *normal = scene->normal;
    const float at[2] = { u, v };
    rsv_vec3 frame[2] = { v3_normalize(
        v3_barycentric(normal[corner[0]], normal[corner[1]], normal[corner[2]], u, v)) };
    if (!rsv_tangent_frame(scene, &ref, corner, at, frame)) return v3(0, 0, 0);
    return v3_mad(v3_scale(frame[0], cosf(rotation)), sinf(rotation), frame[1]);
}

#endif
