#include "element_restore.h"

#include "elements_internal.h"

#include <string.h>

/// Rounding of weights that sum to 1.
#define WEIGHT_TOLERANCE 1e-3f

rsv_status rsv_elements_create_bare(const rsv_scene *scene, const rsv_bsdf *bsdf, float spacing,
    const rsv_elements *alike, rsv_elements **elements)
{
    rsv_elements *e = NULL;
    rsv_status status;
    RSV_TRY(rsv_elements_create_empty(
        rsv_scene_get_view(scene), bsdf, spacing, rsv_scene_get_context(scene), &e));
    RSV_TRY(alike ? rsv_elements_copy_faces(alike, e) : rsv_elements_create_faces(e));
    *elements = e;
    e = NULL;
cleanup:
    rsv_elements_destroy(e);
    return status;
}

// ---- cells ----------------------------------------------------------------------------------------

uint8_t *rsv_elements_splits(const rsv_elements *e)
{
    uint8_t *split = rsv_alloc(e->context, e->slot_count, 1);
    for (size_t slot = 0; split && slot < e->slot_count; slot++)
        split[slot] = (e->slot[slot] & RSV_SLOT_SPLIT) != 0;
    return split;
}

typedef struct cell_builder {
    rsv_elements *elements;
    const uint8_t *split;
    size_t next_slot, next_cell;
} cell_builder;

/// Numbers slots and cells in the order that rsv_elements_split_cells leaves. False if a split leads too deep or too
/// far.
static bool place_cell(cell_builder *b, size_t slot, rsv_cell cell)
{
    rsv_elements *e = b->elements;
    if (!b->split[slot]) {
        if (b->next_cell == e->cell_count) return false;
        e->cell[b->next_cell] = cell;
        e->slot[slot] = (uint32_t)b->next_cell++;
        return true;
    }
    size_t first = b->next_slot;
    if (cell.level >= RSV_MAX_LEVEL || first + 4 > e->slot_count) return false;
    b->next_slot += 4;
    e->slot[slot] = RSV_SLOT_SPLIT | (uint32_t)first;
    for (int k = 0; k < 4; k++)
        if (!place_cell(b, first + (size_t)k, rsv_child_cell(cell, k))) return false;
    return true;
}

static bool place_grids(cell_builder *b)
{
    const rsv_elements *e = b->elements;
    for (uint32_t face = 0; face < e->face_count; face++) {
        int side = 1 << e->face_level[face];
        size_t slot = e->face_slot[face];
        for (int j = 0; j < side; j++)
            for (int n = 0; n < 2 * (side - j) - 1; n++, slot++) {
                rsv_cell cell = { face, (uint16_t)(n / 2), (uint16_t)j, e->face_level[face],
                    (uint8_t)(n & 1) };
                if (!place_cell(b, slot, cell)) return false;
            }
    }
    return b->next_slot == e->slot_count && b->next_cell == e->cell_count;
}

/// First slots of the grids; false if they are too many. @param count out
static bool plan_grids(rsv_elements *e, size_t slot_count, size_t *count)
{
    *count = 0;
    for (size_t face = 0; face < e->face_count; face++) {
        if (e->face_level[face] > RSV_MAX_LEVEL) return false;
        e->face_slot[face] = (uint32_t)*count;
        *count += (size_t)1 << (2 * e->face_level[face]);
        if (*count > slot_count) return false;
    }
    return slot_count < RSV_SLOT_SPLIT;
}

rsv_status rsv_elements_restore_cells(rsv_elements *e, const uint8_t *split, size_t slot_count)
{
    size_t grid, splits = 0;
    for (size_t slot = 0; slot < slot_count; slot++)
        splits += split[slot] != 0;
    if (!plan_grids(e, slot_count, &grid) || splits != (slot_count - grid) / 4)
        return rsv_fail(RSV_ERROR_FORMAT, "elements: the grids do not fit the cells");
    e->slot_count = slot_count;
    e->cell_count = slot_count - splits;
    e->slot = rsv_alloc(e->context, slot_count, sizeof *e->slot);
    e->cell = rsv_alloc(e->context, e->cell_count, sizeof *e->cell);
    if (!e->slot || !e->cell) return RSV_ERROR_MEMORY;
    cell_builder b = { e, split, grid, 0 };
    return place_grids(&b)
               ? RSV_OK
               : rsv_fail(RSV_ERROR_FORMAT, "elements: the splits do not fit the cells");
}

// ---- nodes ----------------------------------------------------------------------------------------

static bool supports_are_sound(const rsv_elements *e)
{
    if (e->cell_count >= RSV_NONE / 4 || e->support_begin[0] != 0 ||
        e->support_begin[e->node_count] != 3 * e->cell_count)
        return false;
    for (size_t n = 0; n < e->node_count; n++)
        if (e->support_begin[n] >= e->support_begin[n + 1] || e->node_face[n] >= e->face_count ||
            !(e->node_area[n] >= 0 && isfinite(e->node_area[n])))
            return false;
    for (size_t k = 0; k < 3 * e->cell_count; k++)
        if (e->support[k] / 4 >= e->cell_count || e->support[k] % 4 == 3) return false;
    return true;
}

static bool cells_are_sound(const rsv_elements *e)
{
    for (size_t c = 0; c < e->cell_count; c++)
        for (int k = 0; k < 3; k++)
            if (e->cell_node[c][k] >= e->node_count) return false;
    return true;
}

/// Parents are free or hang earlier in the list: so every specular path of them ends.
static bool parents_are_sound(const rsv_elements *e, size_t index)
{
    const rsv_hanging *h = &e->hanging[index];
    float sum = 0;
    for (int p = 0; p < RSV_PARENTS; p++) {
        if (h->parent[p] >= e->node_count || !(h->weight[p] >= 0 && h->weight[p] <= 1))
            return false;
        uint32_t above = e->node_hanging[h->parent[p]];
        if (h->weight[p] > 0 && above != RSV_NONE && above >= index) return false;
        sum += h->weight[p];
    }
    return fabsf(sum - 1) < WEIGHT_TOLERANCE;
}

static bool hang_nodes(rsv_elements *e)
{
    for (size_t k = 0; k < e->hanging_count; k++) {
        uint32_t node = e->hanging[k].node;
        if (node >= e->node_count || e->node_hanging[node] != RSV_NONE) return false;
        e->node_hanging[node] = (uint32_t)k;
    }
    for (size_t k = 0; k < e->hanging_count; k++)
        if (!parents_are_sound(e, k)) return false;
    return true;
}

rsv_status rsv_elements_restore_nodes(rsv_elements *e)
{
    e->node_hanging = rsv_alloc(e->context, e->node_count, sizeof *e->node_hanging);
    if (!e->node_hanging) return RSV_ERROR_MEMORY;
    memset(e->node_hanging, 0xff, e->node_count * sizeof *e->node_hanging);
    if (!supports_are_sound(e) || !cells_are_sound(e))
        return rsv_fail(RSV_ERROR_FORMAT, "elements: cells and nodes do not fit each other");
    if (!hang_nodes(e))
        return rsv_fail(RSV_ERROR_FORMAT, "elements: hanging nodes have no sound parents");
    return RSV_OK;
}

// ---- cuts -----------------------------------------------------------------------------------------

uint32_t *rsv_elements_cut_cells(const rsv_elements *e)
{
    uint32_t *cell = rsv_alloc(e->context, e->cut_count, sizeof *cell);
    for (uint32_t c = 0; cell && e->cell_cut && c < e->cell_count; c++)
        if (e->cell_cut[c] != RSV_NONE) cell[e->cell_cut[c]] = c;
    return cell;
}

rsv_status rsv_elements_restore_cuts(rsv_elements *e, const uint32_t *cell)
{
    if (e->cut_count == 0) return RSV_OK;
    e->cell_cut = rsv_reserve(e->context, e->cell_count, sizeof *e->cell_cut);
    if (!e->cell_cut) return RSV_ERROR_MEMORY;
    memset(e->cell_cut, 0xff, e->cell_count * sizeof *e->cell_cut);
    for (size_t k = 0; k < e->cut_count; k++) {
        if (cell[k] >= e->cell_count || (k > 0 && cell[k] <= cell[k - 1]))
            return rsv_fail(RSV_ERROR_FORMAT, "elements: the cells that walls cut do not exist");
        e->cell_cut[cell[k]] = (uint32_t)k;
    }
    return RSV_OK;
}
