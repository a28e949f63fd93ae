#include "surface_body.h"

float rsv_triangle_area(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 e1 = v3_sub(scene->position[corner[1]], a), e2 = v3_sub(scene->position[corner[2]], a);
    return 0.5f * v3_length(v3_cross(e1, e2));
}

/// Textures that leave a Lambert surface one.
static bool keeps_lambert(const rsv_material *m)
{
    for (size_t i = 0; i < m->texture_count; i++) {
        rsv_texture_role role = m->textures[i].role;
        if (role != RSV_TEXTURE_BASE_COLOR && role != RSV_TEXTURE_EMISSION &&
            role != RSV_TEXTURE_NORMAL && role != RSV_TEXTURE_OPACITY &&
            role != RSV_TEXTURE_CLEARCOAT_NORMAL)
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
