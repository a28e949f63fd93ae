#include "body.h"

/// Borrowed arrays of either kind of body.
typedef struct triangles {
    const rsv_vec3 *position, *normal;
    const uint32_t *index;
    size_t vertex_count, triangle_count;
} triangles;

/// Six times the volume that the triangles enclose; negative if they face inwards. Seen from a corner of the bounds,
/// not the origin, which may be far away.
static double signed_volume(const triangles *t, rsv_vec3 from)
{
    double sum = 0;
    for (size_t i = 0; i < t->triangle_count; i++) {
        const uint32_t *corner = &t->index[3 * i];
        rsv_vec3 a = v3_sub(t->position[corner[0]], from);
        rsv_vec3 b = v3_sub(t->position[corner[1]], from);
        rsv_vec3 c = v3_sub(t->position[corner[2]], from);
        sum += (double)v3_dot(a, v3_cross(b, c));
    }
    return sum;
}

static void find_bounds(const triangles *t, rsv_vec3 *low, rsv_vec3 *high)
{
    *low = *high = t->position[t->index[0]];
    for (size_t i = 1; i < 3 * t->triangle_count; i++) {
        *low = v3_min(*low, t->position[t->index[i]]);
        *high = v3_max(*high, t->position[t->index[i]]);
    }
}

/// Uniform scale and shift that put the bounding box in its place.
static void fit(const rsv_body *body, rsv_vec3 low, rsv_vec3 high, float transform[16])
{
    rsv_vec3 size = v3_sub(high, low), middle = v3_scale(v3_add(low, high), 0.5f);
    float scale =
        f_min(f_min(body->size.x / f_max(size.x, 1e-30f), body->size.y / f_max(size.y, 1e-30f)),
            body->size.z / f_max(size.z, 1e-30f));
    const float placed[16] = { scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0,
        body->foot.x - scale * middle.x, body->foot.y - scale * low.y,
        body->foot.z - scale * middle.z, 1 };
    for (int i = 0; i < 16; i++)
        transform[i] = placed[i];
}

static rsv_status add_turned(rsv_scene *scene, rsv_mesh_desc mesh, uint32_t *id)
{
    rsv_status status;
    rsv_vec3 *normal = rsv_alloc(scene->context, mesh.vertex_count, sizeof *normal);
    uint32_t *index = rsv_alloc(scene->context, mesh.triangle_count, 3 * sizeof *index);
    if (!normal || !index) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < mesh.vertex_count; i++)
        normal[i] = v3_neg(mesh.normals[i]);
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        index[i] = mesh.indices[i / 3 * 3 + 2 - i % 3];
    mesh.normals = normal;
    mesh.indices = index;
    RSV_TRY(rsv_scene_add_mesh(scene, &mesh, id));
cleanup:
    rsv_free(scene->context, normal);
    rsv_free(scene->context, index);
    return status;
}

static rsv_status place(rsv_scene *scene, const rsv_body *body, const triangles *t)
{
    rsv_status status;
    rsv_vec3 low, high;
    float transform[16];
    uint32_t id;
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = body->name,
        .positions = t->position,
        .normals = t->normal,
        .vertex_count = t->vertex_count,
        .indices = t->index,
        .triangle_count = t->triangle_count,
        .material = body->material };
    find_bounds(t, &low, &high);
    fit(body, low, high, transform);
    if (signed_volume(t, low) < 0)
        RSV_TRY(add_turned(scene, mesh, &id));
    else
        RSV_TRY(rsv_scene_add_mesh(scene, &mesh, &id));
    RSV_TRY(rsv_scene_add_instance(scene, id, transform, body->name));
cleanup:
    return status;
}

static rsv_status place_stand_in(rsv_scene *scene, const rsv_body *body)
{
    rsv_status status;
    const rsv_sculpture *sculpture = &body->stand_in;
    rsv_isosurface surface;
    status = rsv_isosurface_of_size(scene->context, sculpture->field, sculpture->low,
        sculpture->high, body->triangles, &surface);
    if (status != RSV_OK) return status;
    const triangles t = { surface.position, surface.normal, surface.index, surface.vertex_count,
        surface.triangle_count };
    status = place(scene, body, &t);
    rsv_isosurface_release(scene->context, &surface);
    return status;
}

rsv_status rsv_add_body(rsv_scene *scene, const rsv_body *body)
{
    if (!body->given) return place_stand_in(scene, body);
    const rsv_scene_view *view = rsv_scene_get_view(body->given);
    const triangles t = { view->position, view->normal, *view->triangle, view->vertex_count,
        view->triangle_count };
    return place(scene, body, &t);
}
