/// Scenes made of some objects of another one, copied bit for bit.
#include "resolvent/edit.h"

#include "../core/descriptor.h"
#include "moment.h"
#include "restore.h"
#include "scene.h"
#include "variant.h"

#include <string.h>

void rsv_scene_edit_init(rsv_scene_edit *edit, size_t size)
{
    const rsv_scene_edit defaults = { .size = sizeof defaults };
    rsv_desc_fill(edit, size, &defaults);
}

/// An object's triangles and vertices, which are contiguous.
typedef struct object_range {
    uint32_t triangle, triangle_end, vertex, vertex_end;
} object_range;

typedef struct editor {
    rsv_context *context;
    const rsv_scene_view *from;
    const rsv_scene_edit *edit;
    object_range *range; ///< [from->object_count]
    size_t object_count, vertex_count, triangle_count;
    rsv_vec3 *position, *normal;
    float (*uv[2])[2], (*tangent)[4], (*color)[4];
    uint32_t (*triangle)[3], *material, *object;
    const char **name;
} editor;

static uint32_t source_of(const editor *e, size_t object)
{
    return e->edit->object ? e->edit->object[object] : (uint32_t)object;
}

static void find_ranges(editor *e)
{
    const rsv_scene_view *v = e->from;
    for (uint32_t t = 0; t < v->triangle_count; t++) {
        object_range *range = &e->range[v->triangle_object[t]];
        if (!range->triangle_end)
            *range = (object_range){ t, t, v->triangle[t][0], v->triangle[t][0] };
        range->triangle_end = t + 1;
        for (int k = 0; k < 3; k++)
            if (v->triangle[t][k] >= range->vertex_end) range->vertex_end = v->triangle[t][k] + 1;
    }
}

static rsv_status count_parts(editor *e)
{
    e->object_count = e->edit->object ? e->edit->object_count : e->from->object_count;
    for (size_t k = 0; k < e->object_count; k++) {
        uint32_t source = source_of(e, k);
        if (source >= e->from->object_count)
            return rsv_fail(RSV_ERROR_ARGUMENT, "scene: object %u does not exist; there are %zu",
                source, e->from->object_count);
        const object_range *range = &e->range[source];
        e->vertex_count += range->vertex_end - range->vertex;
        e->triangle_count += range->triangle_end - range->triangle;
    }
    if (e->vertex_count < RSV_NONE && e->triangle_count < RSV_NONE) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED, "scene: the edit needs more than 2^32 vertices");
}

static bool allocate(editor *e)
{
    rsv_context *c = e->context;
    const rsv_scene_view *v = e->from;
    size_t vertices = e->vertex_count, triangles = e->triangle_count;
    e->position = rsv_alloc(c, vertices, sizeof *e->position);
    e->normal = rsv_alloc(c, vertices, sizeof *e->normal);
    for (int set = 0; set < 2; set++)
        if (v->uv[set]) e->uv[set] = rsv_alloc(c, vertices, sizeof *e->uv[set]);
    if (v->tangent) e->tangent = rsv_alloc(c, vertices, sizeof *e->tangent);
    if (v->color) e->color = rsv_alloc(c, vertices, sizeof *e->color);
    e->triangle = rsv_alloc(c, triangles, sizeof *e->triangle);
    e->material = rsv_alloc(c, triangles, sizeof *e->material);
    e->object = rsv_alloc(c, triangles, sizeof *e->object);
    e->name = rsv_alloc(c, e->object_count, sizeof *e->name);
    return e->position && e->normal && (e->uv[0] || !v->uv[0]) && (e->uv[1] || !v->uv[1]) &&
           (e->tangent || !v->tangent) && (e->color || !v->color) && e->triangle && e->material &&
           e->object && e->name;
}

static void release(editor *e)
{
    rsv_context *c = e->context;
    rsv_free(c, e->range);
    rsv_free(c, e->position);
    rsv_free(c, e->normal);
    rsv_free(c, e->uv[0]);
    rsv_free(c, e->uv[1]);
    rsv_free(c, e->tangent);
    rsv_free(c, e->color);
    rsv_free(c, e->triangle);
    rsv_free(c, e->material);
    rsv_free(c, e->object);
    rsv_free(c, (void *)e->name);
}

static void copy_vertices(const editor *e, const object_range *range, size_t to)
{
    const rsv_scene_view *v = e->from;
    size_t from = range->vertex, count = range->vertex_end - range->vertex;
    memcpy(e->position + to, v->position + from, count * sizeof *e->position);
    memcpy(e->normal + to, v->normal + from, count * sizeof *e->normal);
    for (int set = 0; set < 2; set++)
        if (v->uv[set]) memcpy(e->uv[set] + to, v->uv[set] + from, count * sizeof *e->uv[set]);
    if (v->tangent) memcpy(e->tangent + to, v->tangent + from, count * sizeof *e->tangent);
    if (v->color) memcpy(e->color + to, v->color + from, count * sizeof *e->color);
}

static void copy_objects(editor *e)
{
    const rsv_scene_view *v = e->from;
    uint32_t vertex = 0, triangle = 0;
    for (uint32_t k = 0; k < e->object_count; k++) {
        const object_range *range = &e->range[source_of(e, k)];
        e->name[k] = v->object_name[source_of(e, k)];
        if (range->triangle == range->triangle_end) continue;
        copy_vertices(e, range, vertex);
        for (uint32_t t = range->triangle; t < range->triangle_end; t++, triangle++) {
            for (int c = 0; c < 3; c++)
                e->triangle[triangle][c] = v->triangle[t][c] - range->vertex + vertex;
            e->material[triangle] = v->triangle_material[t];
            e->object[triangle] = k;
        }
        vertex += range->vertex_end - range->vertex;
    }
}

static bool is_share(float value) { return value >= 0 && value <= 1; }

static rsv_status edit_materials(const rsv_scene_edit *edit, rsv_scene *scene)
{
    for (size_t k = 0; k < edit->material_count; k++) {
        const rsv_material_edit *m = &edit->material[k];
        const rsv_rgb *c = &m->base_color;
        if (m->material >= scene->material_count)
            return rsv_fail(RSV_ERROR_ARGUMENT, "scene: material %u does not exist; there are %zu",
                m->material, scene->material_count);
        rsv_material *to = &scene->material[m->material];
        if (!is_share(c->r) || !is_share(c->g) || !is_share(c->b) || !is_share(m->roughness) ||
            !is_share(m->metallic))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "scene: colour, roughness and metalness of material '%s' must be from 0 to 1",
                to->name);
        to->base_color = m->base_color;
        to->roughness = m->roughness;
        to->metallic = m->metallic;
    }
    return RSV_OK;
}

static rsv_status fill(editor *e, const rsv_scene *scene, rsv_scene *result)
{
    rsv_status status;
    e->range = rsv_alloc(e->context, e->from->object_count, sizeof *e->range);
    RSV_TRY(e->range ? RSV_OK : RSV_ERROR_MEMORY);
    find_ranges(e);
    RSV_TRY(count_parts(e));
    RSV_TRY(allocate(e) ? RSV_OK : RSV_ERROR_MEMORY);
    copy_objects(e);
    RSV_TRY(rsv_scene_begin_moment(result, scene));
    RSV_TRY(edit_materials(e->edit, result));
    rsv_scene_view view = *e->from;
    view.position = e->position;
    view.normal = e->normal;
    for (int set = 0; set < 2; set++)
        view.uv[set] = (const float(*)[2])e->uv[set];
    view.tangent = (const float(*)[4])e->tangent;
    view.color = (const float(*)[4])e->color;
    view.triangle = (const uint32_t(*)[3])e->triangle;
    view.triangle_material = e->material;
    view.triangle_object = e->object;
    view.object_name = e->name;
    view.vertex_count = e->vertex_count;
    view.triangle_count = e->triangle_count;
    view.object_count = e->object_count;
    RSV_TRY(rsv_scene_restore_rest(result, &view));
cleanup:
    return status;
}

rsv_status rsv_scene_apply_edit(
    const rsv_scene *scene, const rsv_scene_edit *edit, rsv_scene **result)
{
    rsv_status status;
    rsv_scene *edited = NULL;
    rsv_scene_edit settings = rsv_default_scene_edit();
    editor e = { .context = scene->context, .from = &scene->view, .edit = &settings };
    RSV_TRY(rsv_scene_require_committed(scene));
    RSV_TRY(rsv_scene_refuse_fog(scene, "an edited scene"));
    RSV_TRY(RSV_READ_DESC(rsv_scene_edit, &settings, edit));
    RSV_TRY(rsv_scene_create(scene->context, &edited));
    RSV_TRY(fill(&e, scene, edited));
    *result = edited;
    edited = NULL;
cleanup:
    release(&e);
    rsv_scene_destroy(edited);
    return status;
}

// ---- versions in between --------------------------------------------------------------------------

/// Puts vertices of objects back to where they were.
static void put_back(const rsv_scene *early, const bool *moved, rsv_scene *mixed)
{
    for (size_t t = 0; t < early->triangle_count; t++)
        for (int k = 0; k < 3 && !moved[early->triangle_object[t]]; k++) {
            uint32_t vertex = early->triangle[t][k];
            mixed->position[vertex] = early->position[vertex];
            mixed->normal[vertex] = early->normal[vertex];
            if (mixed->tangent)
                memcpy(mixed->tangent[vertex], early->tangent[vertex], sizeof *mixed->tangent);
        }
}

static bool is_same_shape(const rsv_scene *a, const rsv_scene *b)
{
    size_t bytes = a->triangle_count * sizeof *a->triangle;
    return a->triangle_count == b->triangle_count && a->vertex_count == b->vertex_count &&
           a->object_count == b->object_count && !a->tangent == !b->tangent &&
           memcmp(a->triangle, b->triangle, bytes) == 0 &&
           memcmp(a->triangle_object, b->triangle_object, a->triangle_count * sizeof(uint32_t)) ==
               0;
}

rsv_status rsv_scene_mix(
    const rsv_scene *early, const rsv_scene *late, const bool *moved, rsv_scene **result)
{
    rsv_status status;
    rsv_scene *mixed = NULL;
    RSV_TRY(rsv_scene_require_committed(early));
    RSV_TRY(rsv_scene_require_committed(late));
    if (!is_same_shape(early, late))
        RSV_TRY(rsv_fail(RSV_ERROR_ARGUMENT, "scene: the two versions have different triangles"));
    RSV_TRY(rsv_scene_vary(late, &mixed));
    RSV_TRY(rsv_scene_vary_positions(mixed));
    RSV_TRY(rsv_scene_vary_normals(mixed));
    put_back(early, moved, mixed);
    RSV_TRY(rsv_scene_update_bounds(mixed));
    *result = mixed;
    mixed = NULL;
cleanup:
    rsv_scene_destroy(mixed);
    return status;
}
