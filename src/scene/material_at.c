#include "material_at_body.h"

rsv_material rsv_material_mean(const rsv_scene_view *scene, uint32_t material)
{
    rsv_material m = scene->material[material];
    for (size_t i = 0; i < m.texture_count; i++)
        rsv_material_multiply(
            &m, m.textures[i].role, rsv_texture_mean(&scene->texture[m.textures[i].texture]));
    if (scene->material_varies[material] & RSV_VARIES_BY_OPACITY) m.opacity *= 0.5f;
    if (m.alpha_cutoff > 0) m.opacity = 1;
    return m;
}

bool rsv_find_blended(const rsv_scene_view *scene)
{
    for (uint32_t m = 0; m < scene->material_count; m++)
        if (rsv_is_blended(scene, m)) return true;
    return false;
}

const rsv_material *rsv_find_cut_out(const rsv_scene_view *scene)
{
    for (size_t m = 0; m < scene->material_count; m++)
        if (scene->material[m].alpha_cutoff > 0) return &scene->material[m];
    return NULL;
}
