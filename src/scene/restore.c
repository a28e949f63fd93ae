#include "restore.h"

#include "../core/vec.h"
#include "scene.h"

#include <string.h>

/// Rounding of a unit vector's length.
#define UNIT_TOLERANCE 1e-4f

static bool is_unit(rsv_vec3 v) { return fabsf(v3_length(v) - 1) < UNIT_TOLERANCE; }

// ---- geometry -------------------------------------------------------------------------------------

static rsv_status copy_floats(
    rsv_context *context, const void *from, size_t count, const char *what, void *to)
{
    if (!from) return RSV_OK;
    float *copy = rsv_alloc(context, count, sizeof *copy);
    if (!copy) return RSV_ERROR_MEMORY;
    *(float **)to = copy;
    memcpy(copy, from, count * sizeof *copy);
    for (size_t k = 0; k < count; k++)
        if (!isfinite(copy[k])) return rsv_fail(RSV_ERROR_FORMAT, "scene: %s are not finite", what);
    return RSV_OK;
}

static rsv_status copy_indices(
    rsv_context *context, const void *from, size_t count, size_t bound, const char *what, void *to)
{
    uint32_t *copy = rsv_alloc(context, count, sizeof *copy);
    if (!copy) return RSV_ERROR_MEMORY;
    *(uint32_t **)to = copy;
    memcpy(copy, from, count * sizeof *copy);
    for (size_t k = 0; k < count; k++)
        if (copy[k] >= bound)
            return rsv_fail(RSV_ERROR_FORMAT, "scene: number %zu of the triangles' %s is %u of %zu",
                k, what, copy[k], bound);
    return RSV_OK;
}

static rsv_status copy_names(rsv_scene *scene, const rsv_scene_view *view)
{
    scene->object_name = rsv_alloc(scene->context, view->object_count, sizeof *scene->object_name);
    if (!scene->object_name) return RSV_ERROR_MEMORY;
    for (; scene->object_count < view->object_count; scene->object_count++) {
        char *name = rsv_copy_string(scene->context, view->object_name[scene->object_count]);
        if (!name) return RSV_ERROR_MEMORY;
        scene->object_name[scene->object_count] = name;
    }
    return RSV_OK;
}

static rsv_status copy_arrays(rsv_scene *scene, const rsv_scene_view *view)
{
    rsv_status status;
    rsv_context *context = scene->context;
    size_t vertices = view->vertex_count, triangles = view->triangle_count;
    if (vertices >= RSV_NONE || triangles >= RSV_NONE || view->object_count > triangles)
        return rsv_fail(RSV_ERROR_FORMAT, "scene: %zu vertices, %zu triangles and %zu objects",
            vertices, triangles, view->object_count);
    RSV_TRY(copy_floats(context, view->position, 3 * vertices, "positions", &scene->position));
    RSV_TRY(copy_floats(context, view->normal, 3 * vertices, "normals", &scene->normal));
    for (int set = 0; set < 2; set++)
        RSV_TRY(copy_floats(
            context, view->uv[set], 2 * vertices, "texture coordinates", &scene->uv[set]));
    RSV_TRY(copy_floats(context, view->tangent, 4 * vertices, "tangents", &scene->tangent));
    RSV_TRY(copy_floats(context, view->color, 4 * vertices, "colours", &scene->color));
    RSV_TRY(copy_indices(
        context, view->triangle, 3 * triangles, vertices, "corners", &scene->triangle));
    RSV_TRY(copy_indices(context, view->triangle_material, triangles, scene->material_count,
        "materials", &scene->triangle_material));
    RSV_TRY(copy_indices(context, view->triangle_object, triangles, view->object_count, "objects",
        &scene->triangle_object));
    RSV_TRY(copy_names(scene, view));
    scene->vertex_count = vertices;
    scene->triangle_count = triangles;
cleanup:
    return status;
}

/// Checks what flattening ensures: areas above 0, unit normals on the front, contiguous triangles and vertices of
/// objects.
static rsv_status check_triangles(const rsv_scene *scene)
{
    uint32_t first = 0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        const uint32_t *corner = scene->triangle[t], *object = scene->triangle_object + t;
        const rsv_vec3 *p = scene->position;
        rsv_vec3 geometric;
        if (t == 0 || object[0] != object[-1]) first = corner[0];
        bool sound = (t == 0 || object[0] >= object[-1]) &&
                     rsv_triangle_normal(p[corner[0]], p[corner[1]], p[corner[2]], &geometric);
        for (int k = 0; sound && k < 3; k++) {
            rsv_vec3 normal = scene->normal[corner[k]];
            sound = corner[k] >= first && is_unit(normal) && v3_dot(normal, geometric) > 0;
        }
        if (!sound)
            return rsv_fail(RSV_ERROR_FORMAT,
                "scene: triangle %zu has no area, no usable normals or no place in its object", t);
    }
    return RSV_OK;
}

/// Lookups and products rely on shares.
static rsv_status check_colors(const rsv_scene *scene)
{
    for (size_t k = 0; scene->color && k < 4 * scene->vertex_count; k++) {
        float value = scene->color[k / 4][k % 4];
        if (!(value >= 0 && value <= 1))
            return rsv_fail(
                RSV_ERROR_FORMAT, "scene: the colour of vertex %zu is %g", k / 4, value);
    }
    return RSV_OK;
}

// ---- materials, lights, cameras -------------------------------------------------------------------

static rsv_status add_texture(rsv_scene *scene, const rsv_texture_parts *parts)
{
    rsv_texture texture;
    if (!parts->linear) {
        rsv_texture_desc desc = parts->desc;
        desc.values = parts->value;
        return rsv_scene_add_texture(scene, &desc, NULL);
    }
    rsv_status status = rsv_grow(scene->context, (void **)&scene->texture, &scene->texture_capacity,
        scene->texture_count + 1, sizeof texture);
    if (status == RSV_OK)
        status = rsv_texture_create_linear(scene->context, &parts->desc, parts->linear, &texture);
    if (status == RSV_OK) scene->texture[scene->texture_count++] = texture;
    return status;
}

/// Adding a light makes its direction unit: that may change the last digit of one that is unit already.
static rsv_status add_light(rsv_scene *scene, const rsv_punctual_light *light, const char *node)
{
    const double position[3] = { (double)light->position.x, (double)light->position.y,
        (double)light->position.z };
    rsv_status status = rsv_scene_place_light(scene, light, position, node);
    if (status == RSV_OK && is_unit(light->direction))
        scene->light[scene->light_count - 1].direction = light->direction;
    if (status == RSV_OK && is_unit(light->side))
        scene->light[scene->light_count - 1].side = light->side;
    return status;
}

static rsv_status add_camera(rsv_scene *scene, const rsv_camera *camera, const char *node)
{
    const double position[3] = { (double)camera->position.x, (double)camera->position.y,
        (double)camera->position.z };
    return rsv_scene_place_camera(scene, camera, position, node);
}

static rsv_status add_materials(rsv_scene *scene, const rsv_scene_parts *parts)
{
    rsv_status status = RSV_OK;
    const rsv_scene_view *view = &parts->view;
    for (size_t k = 0; k < view->texture_count; k++)
        RSV_TRY(add_texture(scene, &parts->texture[k]));
    for (size_t k = 0; k < view->material_count; k++)
        RSV_TRY(rsv_scene_add_material(scene, &view->material[k], NULL));
cleanup:
    return status;
}

static rsv_status add_parts(rsv_scene *scene, const rsv_scene_view *view)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < view->luminaire_count; k++)
        RSV_TRY(rsv_scene_add_luminaire(scene, &view->luminaire[k], NULL));
    for (size_t k = 0; k < view->light_count; k++)
        RSV_TRY(add_light(scene, &view->light[k], view->light_node ? view->light_node[k] : NULL));
    for (size_t k = 0; k < view->camera_count; k++)
        RSV_TRY(
            add_camera(scene, &view->camera[k], view->camera_node ? view->camera_node[k] : NULL));
    if (view->environment) RSV_TRY(rsv_scene_set_environment(scene, view->environment));
cleanup:
    return status;
}

rsv_status rsv_scene_restore_rest(rsv_scene *scene, const rsv_scene_view *view)
{
    rsv_status status;
    RSV_TRY(add_parts(scene, view));
    RSV_TRY(copy_arrays(scene, view));
    RSV_TRY(check_triangles(scene));
    RSV_TRY(check_colors(scene));
    for (int axis = 0; axis < 3; axis++)
        scene->origin[axis] = isfinite(view->origin[axis]) ? view->origin[axis] : 0;
    RSV_TRY(rsv_scene_finish(scene));
cleanup:
    return status;
}

rsv_status rsv_scene_restore(rsv_context *context, const rsv_scene_parts *parts, rsv_scene **scene)
{
    rsv_scene *restored = NULL;
    rsv_status status;
    RSV_TRY(rsv_scene_create(context, &restored));
    RSV_TRY(add_materials(restored, parts));
    RSV_TRY(rsv_scene_restore_rest(restored, &parts->view));
    *scene = restored;
    restored = NULL;
cleanup:
    rsv_scene_destroy(restored);
    return status;
}
