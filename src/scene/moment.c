#include "moment.h"

#include <string.h>

static rsv_status copy_refs(rsv_context *context, const rsv_material *from, rsv_material *to)
{
    if (!from->texture_count) return RSV_OK;
    rsv_texture_ref *copy = rsv_alloc(context, from->texture_count, sizeof *copy);
    if (!copy) return RSV_ERROR_MEMORY;
    memcpy(copy, from->textures, from->texture_count * sizeof *copy);
    to->textures = copy;
    return RSV_OK;
}

/// Materials are already within their ranges, and textures know the materials that use them.
static rsv_status copy_materials(rsv_scene *scene, const rsv_scene *rest)
{
    rsv_status status = RSV_OK;
    rsv_context *context = scene->context;
    RSV_TRY(rsv_grow(context, (void **)&scene->material, &scene->material_capacity,
        rest->material_count, sizeof *scene->material));
    for (size_t k = 0; k < rest->material_count; k++) {
        rsv_material *to = &scene->material[k];
        *to = rest->material[k];
        to->textures = NULL;
        to->name = rsv_copy_string(context, rest->material[k].name);
        scene->material_count = k + 1;
        RSV_TRY(to->name ? RSV_OK : RSV_ERROR_MEMORY);
        RSV_TRY(copy_refs(context, &rest->material[k], to));
    }
cleanup:
    return status;
}

static rsv_status share_textures(rsv_scene *scene, const rsv_scene *rest)
{
    rsv_status status = rsv_grow(scene->context, (void **)&scene->texture, &scene->texture_capacity,
        rest->texture_count, sizeof *scene->texture);
    if (status != RSV_OK) return status;
    if (rest->texture_count)
        memcpy(scene->texture, rest->texture, rest->texture_count * sizeof *scene->texture);
    scene->texture_count = rest->texture_count;
    return RSV_OK;
}

rsv_status rsv_scene_begin_moment(rsv_scene *scene, const rsv_scene *rest)
{
    rsv_status status;
    scene->rest = rest;
    RSV_TRY(share_textures(scene, rest));
    RSV_TRY(copy_materials(scene, rest));
cleanup:
    return status;
}

/// Otherwise the view would depend on what moves.
rsv_status rsv_scene_end_moment(rsv_scene *scene)
{
    const rsv_scene *rest = scene->rest;
    if (scene->camera_count || !rest->camera_count) return RSV_OK;
    rsv_vec3 p = rest->camera[0].position;
    const double place[3] = { p.x + rest->origin[0], p.y + rest->origin[1], p.z + rest->origin[2] };
    return rsv_scene_place_camera(scene, &rest->camera[0], place, NULL);
}
