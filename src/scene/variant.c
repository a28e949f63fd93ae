#include "variant.h"

#include "scene.h"

#include <string.h>

static rsv_status copy_materials(const rsv_scene *base, rsv_scene *variant)
{
    variant->material = rsv_alloc(base->context, base->material_count, sizeof *base->material);
    if (!variant->material) return RSV_ERROR_MEMORY;
    if (base->material_count)
        memcpy(variant->material, base->material, base->material_count * sizeof *base->material);
    return RSV_OK;
}

/// Names too: lights may be added to a variant, which frees those of all its lights.
static rsv_status copy_lights(const rsv_scene *base, rsv_scene *variant)
{
    variant->light = rsv_alloc(base->context, base->light_count, sizeof *base->light);
    variant->light_fixture =
        rsv_alloc(base->context, base->light_count, sizeof *base->light_fixture);
    if (!variant->light || !variant->light_fixture) return RSV_ERROR_MEMORY;
    variant->light_capacity = variant->light_fixture_capacity = base->light_count;
    for (size_t k = 0; k < base->light_count; k++) {
        const char *node = base->light_fixture[k].node;
        char *name = rsv_copy_string(base->context, base->light[k].name),
             *own = node ? rsv_copy_string(base->context, node) : NULL;
        variant->light[k] = base->light[k];
        variant->light[k].name = name;
        variant->light_fixture[k] = base->light_fixture[k];
        variant->light_fixture[k].node = own;
        variant->light_count = k + 1;
        if (!name || (node && !own)) return RSV_ERROR_MEMORY;
    }
    return rsv_scene_list_nodes(variant);
}

rsv_status rsv_scene_vary_positions(rsv_scene *variant)
{
    if (variant->owns_positions) return RSV_OK;
    size_t count = variant->vertex_count;
    rsv_vec3 *position = rsv_alloc(variant->context, count, sizeof *position);
    if (!position) return RSV_ERROR_MEMORY;
    memcpy(position, variant->position, count * sizeof *position);
    variant->position = position;
    variant->view.position = position;
    variant->owns_positions = true;
    return rsv_scene_copy_twins(variant);
}

rsv_status rsv_scene_vary_normals(rsv_scene *variant)
{
    if (variant->owns_normals) return RSV_OK;
    size_t count = variant->vertex_count;
    rsv_vec3 *normal = rsv_alloc(variant->context, count, sizeof *normal);
    float(*tangent)[4] =
        variant->tangent ? rsv_alloc(variant->context, count, sizeof *tangent) : NULL;
    if (!normal || (variant->tangent && !tangent)) {
        rsv_free(variant->context, normal);
        return RSV_ERROR_MEMORY;
    }
    memcpy(normal, variant->normal, count * sizeof *normal);
    if (tangent) memcpy(tangent, variant->tangent, count * sizeof *tangent);
    variant->normal = normal;
    variant->tangent = tangent;
    variant->view.normal = normal;
    variant->view.tangent = (const float(*)[4])tangent;
    variant->owns_normals = true;
    return RSV_OK;
}

rsv_status rsv_scene_vary_environment(rsv_scene *variant)
{
    rsv_environment *e = &variant->environment;
    size_t count = (size_t)e->width * e->height;
    if (variant->owns_environment || !e->pixels) return RSV_OK;
    rsv_rgb *pixels = rsv_alloc(variant->context, count, sizeof *pixels);
    if (!pixels) return RSV_ERROR_MEMORY;
    memcpy(pixels, e->pixels, count * sizeof *pixels);
    e->pixels = pixels;
    variant->owns_environment = true;
    return RSV_OK;
}

rsv_status rsv_scene_vary(const rsv_scene *base, rsv_scene **result)
{
    rsv_status status;
    rsv_scene *variant = rsv_alloc(base->context, 1, sizeof *variant);
    if (!variant) return RSV_ERROR_MEMORY;
    *variant = *base;
    variant->base = base;
    variant->owns_positions = variant->owns_normals = variant->owns_environment = false;
    variant->material = NULL;
    variant->volume = NULL;
    variant->light = NULL;
    variant->light_fixture = NULL;
    variant->light_node = NULL;
    variant->light_count = variant->light_capacity = 0;
    if (base->owns_positions) RSV_TRY(rsv_scene_vary_positions(variant));
    if (base->owns_normals) RSV_TRY(rsv_scene_vary_normals(variant));
    if (base->owns_environment) RSV_TRY(rsv_scene_vary_environment(variant));
    RSV_TRY(copy_materials(base, variant));
    RSV_TRY(copy_lights(base, variant));
    variant->view.material = variant->material;
    variant->view.light = variant->light;
    variant->view.environment = variant->environment.pixels ? &variant->environment : NULL;
    variant->view.fog = base->view.fog ? &variant->fog : NULL;
    *result = variant;
    return RSV_OK;
cleanup:
    rsv_scene_destroy(variant);
    return status;
}
