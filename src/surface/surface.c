#include "surface.h"

#include "../scene/material_at.h"

float rsv_triangle_area(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 e1 = v3_sub(scene->position[corner[1]], a), e2 = v3_sub(scene->position[corner[2]], a);
    return 0.5f * v3_length(v3_cross(e1, e2));
}

rsv_surface_point rsv_surface_point_seen(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back, float width)
{
    rsv_surface_point point = rsv_surface_point_at(scene, triangle, u, v, back);
    if (!(scene->material_varies[scene->triangle_material[triangle]] & RSV_VARIES_BY_TEXTURE))
        return point;
    float side = back ? -1.0f : 1.0f;
    rsv_vec3 mapped = rsv_mapped_normal(scene, triangle, u, v, width, v3_scale(point.normal, side));
    mapped = v3_scale(mapped, side);
    if (v3_dot(mapped, point.geometric) > 0) point.normal = mapped;
    return point;
}

/// Textures that leave a Lambert surface one.
static bool keeps_lambert(const rsv_material *m)
{
    for (size_t i = 0; i < m->texture_count; i++) {
        rsv_texture_role role = m->textures[i].role;
        if (role != RSV_TEXTURE_BASE_COLOR && role != RSV_TEXTURE_EMISSION &&
            role != RSV_TEXTURE_NORMAL && role != RSV_TEXTURE_OPACITY)
            return false;
    }
    return true;
}

rsv_bsdf rsv_surface_common_bsdf(const rsv_scene_view *scene, uint32_t material)
{
    if (!scene->material_varies[material])
        return rsv_bsdf_from_material(&scene->material[material]);
    rsv_material mean = rsv_material_mean(scene, material);
    rsv_bsdf bsdf = rsv_bsdf_from_material(&mean);
    bsdf.lambert = bsdf.lambert && keeps_lambert(&mean);
    return bsdf;
}

const rsv_bsdf *rsv_surface_bsdf(const rsv_scene_view *scene, const rsv_bsdf *common,
    uint32_t triangle, float u, float v, float width, rsv_bsdf *storage)
{
    uint32_t material = scene->triangle_material[triangle];
    if (!scene->material_varies[material]) return &common[material];
    rsv_material at = rsv_material_at(scene, triangle, u, v, width);
    rsv_bsdf_variation variation = rsv_bsdf_variation_of(&at);
    *storage = rsv_bsdf_vary(&common[material], &variation);
    if (!storage->solid) storage->opacity = at.opacity;
    return storage;
}
