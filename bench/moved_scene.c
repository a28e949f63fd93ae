#include "moved_scene.h"

#include <math.h>
#include <stdlib.h>

/// The moved object is smaller than this share of the scene.
static const float largest_part = 0.1f;

void cli_object_bounds(const rsv_scene *scene, uint32_t object, rsv_vec3 *low, rsv_vec3 *high)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    uint32_t first;
    size_t count = rsv_scene_object_triangles(scene, object, &first);
    *low = (rsv_vec3){ INFINITY, INFINITY, INFINITY };
    *high = (rsv_vec3){ -INFINITY, -INFINITY, -INFINITY };
    for (size_t k = 0; k < 3 * count; k++) {
        rsv_vec3 p = view->position[view->triangle[first + k / 3][k % 3]];
        *low = (rsv_vec3){ fminf(low->x, p.x), fminf(low->y, p.y), fminf(low->z, p.z) };
        *high = (rsv_vec3){ fmaxf(high->x, p.x), fmaxf(high->y, p.y), fmaxf(high->z, p.z) };
    }
}

static float longest_side(rsv_vec3 low, rsv_vec3 high)
{
    return fmaxf(fmaxf(high.x - low.x, high.y - low.y), high.z - low.z);
}

static bool is_small(const rsv_scene *scene, uint32_t object)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_vec3 low, high;
    cli_object_bounds(scene, object, &low, &high);
    float size = longest_side(low, high);
    return size > 0 && size < largest_part * longest_side(view->bounds_min, view->bounds_max);
}

uint32_t cli_find_movable_object(const rsv_scene *scene)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    size_t *triangles = calloc(view->object_count, sizeof *triangles), most = 0;
    uint32_t best = RSV_NONE;
    for (size_t t = 0; triangles && t < view->triangle_count; t++)
        triangles[view->triangle_object[t]]++;
    for (uint32_t object = 0; triangles && object < view->object_count; object++) {
        if (triangles[object] <= most || !is_small(scene, object)) continue;
        best = object;
        most = triangles[object];
    }
    free(triangles);
    return best;
}

float cli_object_extent(const rsv_scene *scene, uint32_t object)
{
    rsv_vec3 low, high;
    cli_object_bounds(scene, object, &low, &high);
    return high.x - low.x;
}

static bool belong_together(const rsv_scene_view *view, size_t a, size_t b)
{
    return view->triangle_object[a] == view->triangle_object[b] &&
           view->triangle_material[a] == view->triangle_material[b];
}

/// @param place column-major 4x4 @param w 1 = a point, 0 = a direction
static rsv_vec3 put(const float place[16], rsv_vec3 v, float w)
{
    float r[3];
    for (int k = 0; k < 3; k++)
        r[k] = place[k] * v.x + place[4 + k] * v.y + place[8 + k] * v.z + place[12 + k] * w;
    return (rsv_vec3){ r[0], r[1], r[2] };
}

/// Triangles [first, end) of one object and material, as a mesh of their own. @param place NULL = as it is
static rsv_status copy_mesh(
    const rsv_scene_view *view, size_t first, size_t end, const float *place, rsv_scene *copy)
{
    size_t count = 3 * (end - first);
    rsv_vec3 *position = malloc(count * sizeof *position), *normal = malloc(count * sizeof *normal);
    rsv_status status = position && normal ? RSV_OK : RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count && status == RSV_OK; k++) {
        uint32_t vertex = view->triangle[first + k / 3][k % 3];
        position[k] = view->position[vertex];
        normal[k] = view->normal[vertex];
        if (!place) continue;
        position[k] = put(place, position[k], 1);
        normal[k] = put(place, normal[k], 0);
    }
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = view->object_name[view->triangle_object[first]],
        .positions = position,
        .normals = normal,
        .vertex_count = count,
        .triangle_count = end - first,
        .material = view->triangle_material[first] };
    uint32_t id;
    if (status == RSV_OK) status = rsv_scene_add_mesh(copy, &mesh, &id);
    if (status == RSV_OK) status = rsv_scene_add_instance(copy, id, NULL, NULL);
    free(position);
    free(normal);
    return status;
}

static rsv_status copy_all(
    const rsv_scene_view *view, uint32_t object, const float place[16], rsv_scene *copy)
{
    rsv_status status = RSV_OK;
    uint32_t id;
    for (size_t k = 0; k < view->material_count && status == RSV_OK; k++)
        status = rsv_scene_add_material(copy, &view->material[k], &id);
    for (size_t t = 0; t < view->triangle_count && status == RSV_OK;) {
        size_t end = t + 1;
        while (end < view->triangle_count && belong_together(view, t, end))
            end++;
        status = copy_mesh(view, t, end, view->triangle_object[t] == object ? place : NULL, copy);
        t = end;
    }
    for (size_t k = 0; k < view->light_count && status == RSV_OK; k++)
        status = rsv_scene_add_light(copy, &view->light[k]);
    for (size_t k = 0; k < view->camera_count && status == RSV_OK; k++)
        status = rsv_scene_add_camera(copy, &view->camera[k]);
    if (status == RSV_OK && view->environment)
        status = rsv_scene_set_environment(copy, view->environment);
    return status == RSV_OK ? rsv_scene_commit(copy) : status;
}

rsv_status cli_copy_scene_placed(
    const rsv_scene *scene, uint32_t object, const float place[16], rsv_scene **copy)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    *copy = NULL;
    if (view->texture_count > 0 || view->color) return RSV_ERROR_UNSUPPORTED;
    rsv_status status = rsv_scene_create(rsv_scene_get_context(scene), copy);
    if (status == RSV_OK) status = copy_all(view, object, place, *copy);
    if (status == RSV_OK) return status;
    rsv_scene_destroy(*copy);
    *copy = NULL;
    return status;
}

rsv_status cli_copy_scene_moved(
    const rsv_scene *scene, uint32_t object, float metres, rsv_scene **copy)
{
    const float place[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, metres, 0, 0, 1 };
    return cli_copy_scene_placed(scene, object, place, copy);
}
