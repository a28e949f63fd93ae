#include "../core/parallel.h"
#include "../core/references.h"
#include "elements_internal.h"
#include "voxels.h"

#include <string.h>

rsv_status rsv_elements_create_empty(const rsv_scene_view *scene, const rsv_bsdf *bsdf,
    float spacing, rsv_context *context, rsv_elements **elements)
{
    rsv_elements *e = rsv_alloc(context, 1, sizeof *e);
    if (!e) return RSV_ERROR_MEMORY;
    e->context = context;
    e->references = 1;
    e->scene = scene;
    e->bsdf = bsdf;
    e->spacing = spacing;
    *elements = e;
    return RSV_OK;
}

/// Cells only, without nodes.
static rsv_status split_once(
    const rsv_elements *coarser, const uint8_t *split, rsv_elements **finer)
{
    rsv_status status;
    rsv_elements *e = NULL;
    RSV_TRY(rsv_elements_create_empty(
        coarser->scene, coarser->bsdf, coarser->spacing, coarser->context, &e));
    RSV_TRY(rsv_elements_copy_faces(coarser, e));
    RSV_TRY(rsv_elements_split_cells(coarser, split, e));
    *finer = e;
    return RSV_OK;
cleanup:
    rsv_elements_destroy(e);
    return status;
}

static rsv_status refine_once(const rsv_elements *coarser, const uint8_t *split,
    rsv_elements **finer, uint8_t **unbalanced, bool *any_unbalanced)
{
    rsv_elements *e = NULL;
    rsv_status status = split_once(coarser, split, &e);
    if (status == RSV_OK) status = rsv_elements_number_nodes(e, unbalanced, any_unbalanced);
    if (status == RSV_OK)
        *finer = e;
    else
        rsv_elements_destroy(e);
    return status;
}

/// Splits until no edge is halved more than once on its other side. `current` is replaced.
static rsv_status balance(rsv_elements **current, uint8_t *unbalanced, bool any_unbalanced)
{
    rsv_status status = RSV_OK;
    while (any_unbalanced && status == RSV_OK) {
        rsv_elements *finer = NULL;
        uint8_t *still_unbalanced = NULL;
        for (size_t c = 0; c < (*current)->cell_count; c++)
            if ((*current)->cell[c].level >= RSV_MAX_LEVEL) unbalanced[c] = 0;
        status = refine_once(*current, unbalanced, &finer, &still_unbalanced, &any_unbalanced);
        rsv_context *context = (*current)->context;
        rsv_free(context, unbalanced);
        unbalanced = still_unbalanced;
        if (status != RSV_OK) break;
        rsv_elements_destroy(*current);
        *current = finer;
    }
    rsv_free((*current)->context, unbalanced);
    return status;
}

static rsv_status create_grids(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const rsv_spacing *spacing, rsv_elements **elements)
{
    rsv_status status;
    rsv_elements *e = NULL;
    uint8_t *unbalanced = NULL;
    bool any_unbalanced = false;
    RSV_TRY(rsv_elements_create_empty(
        rsv_scene_get_view(scene), bsdf, spacing->metres, rsv_scene_get_context(scene), &e));
    RSV_TRY(rsv_elements_create_faces(e));
    RSV_TRY(rsv_elements_create_grid(e, spacing));
    status = rsv_elements_number_nodes(e, &unbalanced, &any_unbalanced);
    if (status != RSV_OK) {
        rsv_free(e->context, unbalanced);
        goto cleanup;
    }
    RSV_TRY(balance(&e, unbalanced, any_unbalanced));
    *elements = e;
    return RSV_OK;
cleanup:
    rsv_elements_destroy(e);
    return status;
}

typedef struct size_check {
    const rsv_elements *e;
    const rsv_spacing *spacing;
    uint8_t *split; ///< [cell_count], out
    atomic_size_t marked;
} size_check;

static void mark_cells(void *user, rsv_span span)
{
    size_check *check = user;
    size_t marked = 0;
    for (size_t c = span.begin; c < span.end; c++) {
        check->split[c] = rsv_spacing_is_exceeded(check->spacing, check->e, (uint32_t)c);
        marked += check->split[c];
    }
    atomic_fetch_add(&check->marked, marked);
}

/// Cells larger than usual that do not lie in the open.
static size_t mark_too_large(const rsv_elements *e, const rsv_spacing *spacing, uint8_t *split)
{
    size_check check = { e, spacing, split, 0 };
    rsv_parallel_for(e->context, e->cell_count, 256, mark_cells, &check);
    return check.marked;
}

rsv_status rsv_elements_create(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const rsv_spacing *spacing, rsv_elements **elements)
{
    rsv_elements *e = NULL, *finer = NULL;
    rsv_status status = create_grids(scene, bsdf, spacing, &e);
    for (bool done = false; status == RSV_OK && !done;) {
        uint8_t *split = rsv_alloc(e->context, e->cell_count, 1);
        if (!split) status = RSV_ERROR_MEMORY;
        done = !split || mark_too_large(e, spacing, split) == 0;
        if (!done) status = rsv_elements_refine(e, split, &finer);
        rsv_free(e->context, split);
        if (done || status != RSV_OK) continue;
        rsv_elements_destroy(e);
        e = finer;
    }
    if (status == RSV_OK)
        *elements = e;
    else
        rsv_elements_destroy(e);
    return status;
}

rsv_status rsv_elements_refine(
    const rsv_elements *coarser, const uint8_t *split, rsv_elements **elements)
{
    rsv_elements *finer = NULL;
    uint8_t *unbalanced = NULL;
    bool any_unbalanced = false;
    rsv_status status = refine_once(coarser, split, &finer, &unbalanced, &any_unbalanced);
    if (status != RSV_OK) {
        rsv_free(coarser->context, unbalanced);
        return status;
    }
    status = balance(&finer, unbalanced, any_unbalanced);
    if (status != RSV_OK) {
        rsv_elements_destroy(finer);
        return status;
    }
    *elements = finer;
    return RSV_OK;
}

/// Splits cells of `*e` once; it is replaced where any are chosen. @param any out
static rsv_status split_chosen(rsv_split_chooser choose, void *user, rsv_elements **e, bool *any)
{
    rsv_elements *finer = NULL;
    rsv_status status = RSV_OK;
    uint8_t *split = rsv_alloc((*e)->context, (*e)->cell_count, 1);
    if (!split) return RSV_ERROR_MEMORY;
    choose(user, *e, split);
    *any = memchr(split, 1, (*e)->cell_count) != NULL;
    if (*any) status = split_once(*e, split, &finer);
    rsv_free((*e)->context, split);
    if (!finer) return status;
    rsv_elements_destroy(*e);
    *e = finer;
    return status;
}

rsv_status rsv_elements_refine_where(
    const rsv_elements *coarser, rsv_split_chooser choose, void *user, rsv_elements **elements)
{
    rsv_status status;
    rsv_elements *e = NULL;
    uint8_t *unbalanced = NULL, *none = rsv_alloc(coarser->context, coarser->cell_count, 1);
    bool any = true;
    RSV_TRY(none ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(split_once(coarser, none, &e));
    while (any)
        RSV_TRY(split_chosen(choose, user, &e, &any));
    status = rsv_elements_number_nodes(e, &unbalanced, &any);
    if (status != RSV_OK) rsv_free(e->context, unbalanced);
    RSV_TRY(status);
    RSV_TRY(balance(&e, unbalanced, any));
    *elements = e;
    e = NULL;
cleanup:
    rsv_free(coarser->context, none);
    rsv_elements_destroy(e);
    return status;
}

static bool copy_array(rsv_context *context, void *array, size_t count, size_t size)
{
    void **at = array, *copy;
    if (!*at) return true;
    copy = rsv_alloc(context, count, size);
    if (copy && count) memcpy(copy, *at, count * size);
    *at = copy;
    return copy != NULL;
}

#define COPY(field, count) complete &= copy_array(e->context, &e->field, count, sizeof *e->field)

static bool copy_faces(rsv_elements *e)
{
    bool complete = true;
    COPY(face_of[0], e->scene->triangle_count);
    COPY(face_of[1], e->scene->triangle_count);
    COPY(face_triangle, e->face_count);
    COPY(face_back, e->face_count);
    COPY(face_level, e->face_count);
    COPY(face_halvings, e->face_count);
    COPY(face_slot, e->face_count);
    COPY(face_area, e->face_count);
    COPY(face_corner, e->face_count);
    COPY(face_edge, e->face_count);
    COPY(slot, e->slot_count);
    COPY(slot_openness, e->slot_count);
    COPY(cell, e->cell_count);
    COPY(cell_node, e->cell_count);
    COPY(cell_openness, e->cell_count);
    COPY(cell_cut, e->cell_count);
    COPY(cut_side, e->cut_count);
    return complete;
}

static bool copy_nodes(rsv_elements *e)
{
    bool complete = true;
    COPY(node_face, e->node_count);
    COPY(node_area, e->node_count);
    size_t supports = e->support_begin ? e->support_begin[e->node_count] : 0;
    size_t led = e->led_begin ? e->led_begin[e->node_count] : 0;
    COPY(support_begin, e->node_count + 1);
    COPY(support, supports);
    COPY(hanging, e->hanging_count);
    COPY(node_hanging, e->node_count);
    COPY(led_begin, e->node_count + 1);
    COPY(led, led);
    COPY(node_draw, e->node_count);
    return complete;
}

#undef COPY

rsv_status rsv_elements_copy(const rsv_elements *from, const rsv_scene_view *scene,
    const rsv_bsdf *bsdf, rsv_elements **copy)
{
    rsv_elements *e = rsv_alloc(from->context, 1, sizeof *e);
    if (!e) return RSV_ERROR_MEMORY;
    *e = *from;
    e->references = 1;
    e->scene = scene;
    e->bsdf = bsdf;
    bool faces = copy_faces(e),
         nodes = copy_nodes(e); // both, so that nothing is left of the other's
    *copy = e;
    if (faces && nodes) return RSV_OK;
    rsv_elements_destroy(e);
    return RSV_ERROR_MEMORY;
}

rsv_elements *rsv_elements_retain(rsv_elements *e)
{
    if (e) rsv_references_add(&e->references);
    return e;
}

void rsv_elements_destroy(rsv_elements *e)
{
    if (!e || !rsv_references_drop(&e->references)) return;
    rsv_context *context = e->context;
    void *arrays[] = { e->face_of[0], e->face_of[1], e->face_triangle, e->face_back, e->face_level,
        e->face_halvings, e->face_slot, e->face_area, e->face_corner, e->face_edge, e->slot,
        e->slot_openness, e->cell, e->cell_node, e->cell_openness, e->cell_cut, e->cut_side,
        e->node_face, e->node_area, e->support_begin, e->support, e->hanging, e->node_hanging,
        e->led_begin, e->led, e->node_draw };
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        rsv_free(context, arrays[k]);
    rsv_voxels_destroy(e->voxels);
    rsv_free(context, e);
}

size_t rsv_elements_surface_nodes(const rsv_elements *e)
{
    return e->node_count - (e->voxels ? e->voxels->count : 0);
}

size_t rsv_elements_bytes(const rsv_elements *e)
{
    size_t per_face = sizeof *e->face_triangle + sizeof *e->face_back + sizeof *e->face_level +
                      sizeof *e->face_halvings + sizeof *e->face_slot + sizeof *e->face_area +
                      sizeof *e->face_corner + sizeof *e->face_edge;
    size_t per_cell = sizeof *e->cell + sizeof *e->cell_node + 3 * sizeof *e->support +
                      (e->cell_openness ? sizeof *e->cell_openness : 0) +
                      (e->cell_cut ? sizeof *e->cell_cut : 0);
    size_t per_node = sizeof *e->node_face + sizeof *e->node_area + sizeof *e->support_begin +
                      sizeof *e->node_hanging + (e->node_draw ? sizeof *e->node_draw : 0);
    return e->scene->triangle_count * 2 * sizeof *e->face_of[0] + e->face_count * per_face +
           e->slot_count * (sizeof *e->slot + (e->slot_openness != NULL)) +
           e->cell_count * per_cell + e->node_count * per_node +
           e->cut_count * sizeof *e->cut_side + e->hanging_count * sizeof *e->hanging +
           (e->led_begin ? e->node_count * sizeof *e->led_begin +
                               e->led_begin[e->node_count] * sizeof *e->led
                         : 0) +
           (e->voxels
                   ? e->voxels->cell_count * sizeof *e->voxels->begin +
                         e->voxels->count * (sizeof *e->voxels->cell + sizeof *e->voxels->points +
                                                sizeof *e->voxels->place_begin) +
                         e->voxels->place_count * sizeof *e->voxels->place
                   : 0);
}
