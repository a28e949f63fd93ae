/// Elements: data that cannot be found in the scene again and, for other readers, the positions of elements.
#include "../elements/element_restore.h"
#include "../elements/voxels.h"
#include "exchange.h"
#include "table.h"

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

/// Lines on which walls stand in cells.
static rsv_status write_cuts(rsv_tensor_file *file, rsv_elements *e)
{
    if (e->cut_count == 0) return RSV_OK;
    rsv_status status = rsv_tensor_give(
        file, "cell.cut", RSV_TENSOR_U32, 1, e->cut_count, rsv_elements_cut_cells(e));
    if (status != RSV_OK) return status;
    return rsv_tensor_exchange(file, "cell.side", RSV_TENSOR_F32, 3, &e->cut_side, &e->cut_count);
}

/// Files of versions without them have none.
static rsv_status read_cuts(rsv_tensor_file *file, rsv_elements *e)
{
    if (!rsv_tensor_find(file, "cell.cut")) return RSV_OK;
    rsv_status status;
    uint32_t *cell = NULL;
    size_t count = RSV_ANY_COUNT;
    RSV_TRY(rsv_tensor_exchange(file, "cell.cut", RSV_TENSOR_U32, 1, &cell, &count));
    RSV_TRY(rsv_tensor_exchange(file, "cell.side", RSV_TENSOR_F32, 3, &e->cut_side, &count));
    RSV_TRY(rsv_check_numbers(file, "cell.side", e->cut_side[0], 3 * count, -1));
    e->cut_count = count;
    RSV_TRY(rsv_elements_restore_cuts(e, cell));
cleanup:
    rsv_free(file->context, cell);
    return status;
}

static void place_node(const rsv_scene_view *scene, const rsv_elements *e, size_t node,
    rsv_vec3 *position, rsv_vec3 *normal, uint32_t *triangle)
{
    size_t surfaces = rsv_elements_surface_nodes(e);
    if (node < surfaces) {
        rsv_surface_point point = rsv_elements_node_point(scene, e, (uint32_t)node);
        *position = point.position;
        *normal = point.normal;
        *triangle = e->face_triangle[e->node_face[node]];
        return;
    }
    *position = rsv_voxel_centre(e->voxels, (uint32_t)(node - surfaces));
    *normal = v3(0, 0, 0);
    *triangle = RSV_NONE;
}

/// Positions, normals and triangles, for other readers of files.
static rsv_status write_places(
    rsv_tensor_file *file, const rsv_scene_view *scene, const rsv_elements *e)
{
    rsv_status status;
    rsv_vec3 *position = rsv_alloc(e->context, e->node_count, sizeof *position);
    rsv_vec3 *normal = rsv_alloc(e->context, e->node_count, sizeof *normal);
    uint32_t *triangle = rsv_alloc(e->context, e->node_count, sizeof *triangle);
    for (size_t n = 0; position && normal && triangle && n < e->node_count; n++) {
        place_node(scene, e, n, &position[n], &normal[n], &triangle[n]);
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
    RSV_TRY(write_cuts(file, &e));
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
    while (e->node_count > 0 && e->node_face[e->node_count - 1] == RSV_NONE)
        e->node_count--; // voxels come back by themselves
    RSV_TRY(exchange_hanging(file, &h));
    RSV_TRY(join_hanging(e, &h));
    RSV_TRY(rsv_elements_restore_nodes(e));
    RSV_TRY(read_cuts(file, e));
    *elements = e;
    e = NULL;
cleanup:
    free_hanging(file->context, &h);
    rsv_elements_destroy(e);
    return status;
}

// ---- voxels ---------------------------------------------------------------------------------------

static const rsv_column grid_columns[] = {
    RSV_FLOATS(rsv_voxels, low, 3),
    RSV_FLOATS(rsv_voxels, size, 3),
    { "side", RSV_TENSOR_U32, 3, offsetof(rsv_voxels, side), UINT32_MAX },
};

#define GRID_COLUMNS (sizeof grid_columns / sizeof *grid_columns)

/// @param begins [cell_count + 1] @param places of cut voxels, [place_count]
static rsv_status exchange_voxels(rsv_tensor_file *file, rsv_voxels *v)
{
    rsv_status status;
    rsv_tensor_type u32 = RSV_TENSOR_U32;
    size_t any = RSV_ANY_COUNT, begins = file->reading ? any : v->cell_count + 1;
    size_t place_begins = file->reading ? any : v->count + 1;
    RSV_TRY(rsv_tensor_exchange(file, "start", u32, 1, &v->begin, &begins));
    RSV_TRY(rsv_tensor_exchange(file, "points", RSV_TENSOR_U16, 1, &v->points, &v->count));
    if (file->reading) place_begins = v->count + 1;
    RSV_TRY(rsv_tensor_exchange(file, "place_start", u32, 1, &v->place_begin, &place_begins));
    RSV_TRY(rsv_tensor_exchange(file, "place", RSV_TENSOR_F32, 3, &v->place, &v->place_count));
    if (file->reading && begins == 0) return rsv_tensor_fail(file, "start", "is empty");
    v->cell_count = begins - 1;
cleanup:
    return status;
}

rsv_status rsv_write_voxels(rsv_tensor_file *file, const rsv_elements *e)
{
    if (!e->voxels) return RSV_OK;
    rsv_voxels v = *e->voxels;
    rsv_tensor_prefix(file, RSV_VOXEL_PREFIX);
    rsv_status status = rsv_write_table(file, grid_columns, GRID_COLUMNS, &v, 1, sizeof v);
    return status == RSV_OK ? exchange_voxels(file, &v) : status;
}

/// Whether the file's elements are as many as those read.
static rsv_status check_node_count(rsv_tensor_file *file, const rsv_elements *e)
{
    rsv_tensor_prefix(file, RSV_COARSE_PREFIX);
    const rsv_tensor *area = rsv_tensor_find(file, "area");
    if (area && area->rank == 1 && area->shape[0] == e->node_count) return RSV_OK;
    return rsv_tensor_fail(file, "face", "lists other elements in the air than there are voxels");
}

rsv_status rsv_read_voxels(rsv_tensor_file *file, rsv_elements *e)
{
    rsv_status status = RSV_OK;
    rsv_voxels *v = NULL;
    size_t one = 1;
    rsv_tensor_prefix(file, RSV_VOXEL_PREFIX);
    if (e->scene->fog && rsv_tensor_find(file, "low")) {
        RSV_TRY(rsv_read_table(file, grid_columns, GRID_COLUMNS, &v, &one, sizeof *v));
        v->context = file->context;
        v->count = v->place_count = RSV_ANY_COUNT;
        RSV_TRY(exchange_voxels(file, v));
        RSV_TRY(rsv_voxels_restore(v));
        rsv_voxels *own = v;
        v = NULL;
        RSV_TRY(rsv_elements_add_voxels(e, own));
    }
    RSV_TRY(check_node_count(file, e));
cleanup:
    rsv_voxels_destroy(v);
    return status;
}
