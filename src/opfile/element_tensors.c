/// Elements: what cannot be found in the scene again, and for other readers where each element is.
#include "../elements/element_restore.h"
#include "exchange.h"

#include <string.h>

/// Hanging nodes apart from each other's fields.
typedef struct hanging_arrays {
    uint32_t *node;
    uint32_t (*parent)[RSV_PARENTS];
    float (*weight)[RSV_PARENTS];
    size_t count;
} hanging_arrays;

static rsv_status split_hanging(const rsv_elements *e, hanging_arrays *h)
{
    h->count = e->hanging_count;
    h->node = rsv_alloc(e->context, h->count, sizeof *h->node);
    h->parent = rsv_alloc(e->context, h->count, sizeof *h->parent);
    h->weight = rsv_alloc(e->context, h->count, sizeof *h->weight);
    if (!h->node || !h->parent || !h->weight) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < h->count; k++) {
        h->node[k] = e->hanging[k].node;
        memcpy(h->parent[k], e->hanging[k].parent, sizeof *h->parent);
        memcpy(h->weight[k], e->hanging[k].weight, sizeof *h->weight);
    }
    return RSV_OK;
}

static rsv_status join_hanging(rsv_elements *e, const hanging_arrays *h)
{
    e->hanging_count = h->count;
    e->hanging = rsv_alloc(e->context, h->count, sizeof *e->hanging);
    if (!e->hanging) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < h->count; k++) {
        e->hanging[k].node = h->node[k];
        memcpy(e->hanging[k].parent, h->parent[k], sizeof *h->parent);
        memcpy(e->hanging[k].weight, h->weight[k], sizeof *h->weight);
    }
    return RSV_OK;
}

static void free_hanging(rsv_context *context, hanging_arrays *h)
{
    rsv_free(context, h->node);
    rsv_free(context, h->parent);
    rsv_free(context, h->weight);
}

/// Hands the arrays to the file.
static rsv_status give_hanging(rsv_tensor_file *file, hanging_arrays *h)
{
    rsv_status status;
    hanging_arrays own = *h;
    *h = (hanging_arrays){ 0 };
    status = rsv_tensor_give(file, "hanging.node", RSV_TENSOR_U32, 1, own.count, own.node);
    own.node = NULL;
    RSV_TRY(status);
    status =
        rsv_tensor_give(file, "hanging.parent", RSV_TENSOR_U32, RSV_PARENTS, own.count, own.parent);
    own.parent = NULL;
    RSV_TRY(status);
    status =
        rsv_tensor_give(file, "hanging.weight", RSV_TENSOR_F32, RSV_PARENTS, own.count, own.weight);
    own.weight = NULL;
cleanup:
    free_hanging(file->context, &own);
    return status;
}

static rsv_status exchange_hanging(rsv_tensor_file *file, hanging_arrays *h)
{
    rsv_status status;
    rsv_tensor_type u32 = RSV_TENSOR_U32;
    RSV_TRY(rsv_tensor_exchange(file, "hanging.node", u32, 1, &h->node, &h->count));
    RSV_TRY(rsv_tensor_exchange(file, "hanging.parent", u32, RSV_PARENTS, &h->parent, &h->count));
    RSV_TRY(rsv_tensor_exchange(
        file, "hanging.weight", RSV_TENSOR_F32, RSV_PARENTS, &h->weight, &h->count));
cleanup:
    return status;
}

/// Cells around nodes and nodes of cells.
static rsv_status exchange_nodes(rsv_tensor_file *file, rsv_elements *e)
{
    rsv_status status;
    rsv_tensor_type u32 = RSV_TENSOR_U32;
    size_t corners = 3 * e->cell_count, begins = file->reading ? RSV_ANY_COUNT : e->node_count + 1;
    RSV_TRY(rsv_tensor_exchange(file, "cell.node", u32, 3, &e->cell_node, &e->cell_count));
    RSV_TRY(rsv_tensor_exchange(file, "area", RSV_TENSOR_F32, 1, &e->node_area, &e->node_count));
    RSV_TRY(rsv_tensor_exchange(file, "face", u32, 1, &e->node_face, &e->node_count));
    if (file->reading) begins = e->node_count + 1;
    RSV_TRY(rsv_tensor_exchange(file, "support.start", u32, 1, &e->support_begin, &begins));
    RSV_TRY(rsv_tensor_exchange(file, "support.corner", u32, 1, &e->support, &corners));
cleanup:
    return status;
}

/// Places, normals and triangles, for those who read files without us.
static rsv_status write_places(
    rsv_tensor_file *file, const rsv_scene_view *scene, const rsv_elements *e)
{
    rsv_status status;
    rsv_vec3 *position = rsv_alloc(e->context, e->node_count, sizeof *position);
    rsv_vec3 *normal = rsv_alloc(e->context, e->node_count, sizeof *normal);
    uint32_t *triangle = rsv_alloc(e->context, e->node_count, sizeof *triangle);
    for (size_t n = 0; position && normal && triangle && n < e->node_count; n++) {
        rsv_surface_point point = rsv_elements_node_point(scene, e, (uint32_t)n);
        position[n] = point.position;
        normal[n] = point.normal;
        triangle[n] = e->face_triangle[e->node_face[n]];
    }
    // given, an array is the file's, whether it takes it or fails
    status = rsv_tensor_give(file, "position", RSV_TENSOR_F32, 3, e->node_count, position);
    position = NULL;
    RSV_TRY(status);
    status = rsv_tensor_give(file, "normal", RSV_TENSOR_F32, 3, e->node_count, normal);
    normal = NULL;
    RSV_TRY(status);
    status = rsv_tensor_give(file, "triangle", RSV_TENSOR_U32, 1, e->node_count, triangle);
    triangle = NULL;
cleanup:
    rsv_free(e->context, position);
    rsv_free(e->context, normal);
    rsv_free(e->context, triangle);
    return status;
}

rsv_status rsv_write_elements(rsv_tensor_file *file, const char *prefix,
    const rsv_scene_view *scene, const rsv_elements *elements)
{
    if (!elements) return RSV_OK;
    rsv_status status;
    rsv_elements e = *elements;
    hanging_arrays h = { 0 };
    rsv_tensor_prefix(file, prefix);
    float *spacing = rsv_alloc(e.context, 1, sizeof *spacing);
    if (spacing) *spacing = e.spacing;
    RSV_TRY(rsv_tensor_give(file, "spacing", RSV_TENSOR_F32, 1, 1, spacing));
    RSV_TRY(
        rsv_tensor_exchange(file, "face.level", RSV_TENSOR_U8, 1, &e.face_level, &e.face_count));
    RSV_TRY(rsv_tensor_give(
        file, "cell.split", RSV_TENSOR_U8, 1, e.slot_count, rsv_elements_splits(&e)));
    RSV_TRY(exchange_nodes(file, &e));
    RSV_TRY(write_places(file, scene, &e));
    RSV_TRY(split_hanging(&e, &h));
    RSV_TRY(give_hanging(file, &h));
cleanup:
    free_hanging(e.context, &h);
    return status;
}

static rsv_status read_spacing(rsv_tensor_file *file, float *spacing)
{
    float *read = NULL;
    size_t one = 1;
    rsv_status status;
    RSV_TRY(rsv_tensor_exchange(file, "spacing", RSV_TENSOR_F32, 1, &read, &one));
    RSV_TRY(rsv_check_numbers(file, "spacing", read, 1, 0));
    *spacing = *read;
cleanup:
    rsv_free(file->context, read);
    return status;
}

static rsv_status read_cells(rsv_tensor_file *file, rsv_elements *e)
{
    rsv_status status;
    uint8_t *split = NULL, *level = NULL;
    size_t slots = RSV_ANY_COUNT;
    RSV_TRY(rsv_tensor_exchange(file, "face.level", RSV_TENSOR_U8, 1, &level, &e->face_count));
    memcpy(e->face_level, level, e->face_count);
    RSV_TRY(rsv_tensor_exchange(file, "cell.split", RSV_TENSOR_U8, 1, &split, &slots));
    RSV_TRY(rsv_elements_restore_cells(e, split, slots));
cleanup:
    rsv_free(file->context, split);
    rsv_free(file->context, level);
    return status;
}

rsv_status rsv_read_elements(rsv_tensor_file *file, const char *prefix, const rsv_world *world,
    const rsv_elements *alike, rsv_elements **elements)
{
    rsv_status status;
    rsv_elements *e = NULL;
    hanging_arrays h = { .count = RSV_ANY_COUNT };
    float spacing;
    rsv_tensor_prefix(file, prefix);
    if (alike && !rsv_tensor_find(file, "spacing")) return RSV_OK;
    RSV_TRY(read_spacing(file, &spacing));
    RSV_TRY(rsv_elements_create_bare(world->scene.scene, world->bsdf, spacing, alike, &e));
    RSV_TRY(read_cells(file, e));
    e->node_count = RSV_ANY_COUNT;
    status = exchange_nodes(file, e);
    if (status != RSV_OK) goto cleanup;
    RSV_TRY(exchange_hanging(file, &h));
    RSV_TRY(join_hanging(e, &h));
    RSV_TRY(rsv_elements_restore_nodes(e));
    *elements = e;
    e = NULL;
cleanup:
    free_hanging(file->context, &h);
    rsv_elements_destroy(e);
    return status;
}
