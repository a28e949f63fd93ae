#include "light_refinement.h"

#include "../elements/elements.h"

#include <string.h>

rsv_face_walk rsv_face_walk_begin(const rsv_light_view *s)
{
    return (rsv_face_walk){ .solution = s,
        .level = { s->elements, s->fine.elements, s->caustics.elements, s->diffused.elements } };
}

/// A cell, and its position in each level; a missing part counts as whole.
typedef struct refined_cell {
    rsv_cell cell;
    uint32_t slot[RSV_REFINED_LEVELS];
} refined_cell;

static bool is_split(const rsv_face_walk *w, const refined_cell *at)
{
    uint32_t split = 0;
    for (int k = 0; k < RSV_REFINED_LEVELS; k++)
        split |= w->level[k] ? at->slot[k] & RSV_SLOT_SPLIT : 0;
    return split != 0;
}

/// Levels that are whole stay where they are.
static refined_cell child_of(const rsv_face_walk *w, const refined_cell *at, uint32_t child)
{
    refined_cell below = *at;
    below.cell = rsv_child_cell(at->cell, (int)child);
    for (int k = 0; k < RSV_REFINED_LEVELS; k++)
        if (w->level[k] && (at->slot[k] & RSV_SLOT_SPLIT))
            below.slot[k] = w->level[k]->slot[(at->slot[k] & ~RSV_SLOT_SPLIT) + child];
    return below;
}

/// Of a cell in the regular grid of its level. @return as rsv_place_in_grid
static uint32_t grid_index(const rsv_cell *c)
{
    return (uint32_t)rsv_triangle_grid_index(1 << c->level, c->i, c->j, c->flipped);
}

/// @param cell of the coarse elements' grid
static refined_cell coarse_cell(const rsv_face_walk *w, rsv_cell cell)
{
    refined_cell at = { .cell = cell };
    uint32_t index = grid_index(&cell);
    for (int k = 0; k < RSV_REFINED_LEVELS; k++)
        if (w->level[k]) at.slot[k] = w->level[k]->slot[w->level[k]->face_slot[cell.face] + index];
    return at;
}

/// The next cell of a regular grid. @return false after the last
static bool advance(rsv_cell *cell)
{
    uint32_t side = 1u << cell->level;
    if (!cell->flipped && cell->i + cell->j + 1u < side) {
        cell->flipped = 1;
    } else {
        cell->flipped = 0;
        cell->i++;
        if (cell->i + cell->j >= side) cell->i = 0, cell->j++;
    }
    return cell->j < side;
}

static rsv_cell first_cell(const rsv_face_walk *w, uint32_t face)
{
    return (rsv_cell){ .face = face, .level = w->level[0]->face_level[face] };
}

// ---- cells --------------------------------------------------------------------------------------

static void cell_weights(const rsv_cell *cell, float u, float v, float weight[3])
{
    float side = (float)(1 << cell->level);
    float x = u * side - cell->i, y = v * side - cell->j;
    weight[0] = cell->flipped ? x + y - 1 : 1 - x - y;
    weight[1] = cell->flipped ? 1 - x : x;
    weight[2] = cell->flipped ? 1 - y : y;
}

static rsv_rgb add_fields(
    const rsv_face_walk *w, const rsv_field_sum *fields, const refined_cell *at, float u, float v)
{
    rsv_rgb sum = rgb_gray(0);
    for (int f = 0; f < fields->count; f++) {
        const rsv_stored_field *part = &fields->part[f];
        int level = 0;
        for (int k = 0; k < RSV_REFINED_LEVELS; k++)
            if (w->level[k] == part->elements) level = k;
        uint32_t cell = at->slot[level];
        float weight[3];
        cell_weights(&part->elements->cell[cell], u, v, weight);
        for (int k = 0; k < 3; k++)
            sum = rgb_mad(
                sum, part->sign * weight[k], part->value[part->elements->cell_node[cell][k]]);
    }
    return sum;
}

float rsv_light_change(const float before[3], const float after[3], float least)
{
    float change = 0, scale = least;
    for (int c = 0; c < 3; c++) {
        change = f_max(change, fabsf(after[c] - before[c]));
        scale = f_max(scale, f_max(fabsf(before[c]), fabsf(after[c])));
    }
    return scale > 0 ? change / scale : 0;
}

static void set_corner(rsv_face_walk *w, rsv_rgb shown, float *out)
{
    const float after[3] = { shown.r, shown.g, shown.b };
    w->change = f_max(w->change, rsv_light_change(out, after, w->least));
    memcpy(out, after, sizeof after);
    out[3] = 0;
}

static void fill_cell(rsv_face_walk *w, uint32_t index, const refined_cell *at)
{
    rsv_rgb share = rgb_gray(0);
    if (w->detail)
        share =
            rsv_diffused_share(w->solution->diffused.elements, at->slot[RSV_REFINED_LEVELS - 1]);
    for (int k = 0; k < 3; k++) {
        float u, v, *out = w->cell[index].corner[k];
        rsv_cell_corner(&at->cell, k, &u, &v);
        rsv_rgb irradiance = add_fields(w, w->sum, at, u, v);
        if (w->detail)
            irradiance = rgb_add(irradiance, rgb_mul(share, add_fields(w, w->detail, at, u, v)));
        set_corner(w, rgb_add(w->offset, rgb_mul(w->scale, irradiance)), out);
    }
}

/// @param index of the cell in the table; cells coarser than the grid have none
static void walk_cell(rsv_face_walk *w, const refined_cell *at, uint32_t index)
{
    const rsv_cell *c = &at->cell;
    bool above_grid = c->level < w->grid_level;
    if (c->level == w->grid_level) index = w->grid + grid_index(c);
    if (!above_grid && !is_split(w, at)) {
        if (w->cell) fill_cell(w, index, at);
        return;
    }
    uint32_t first = w->next;
    if (!above_grid) {
        w->next += 4;
        if (w->cell) memcpy(&w->cell[index].corner[0][3], &first, sizeof first);
    }
    for (uint32_t child = 0; child < 4; child++) {
        refined_cell below = child_of(w, at, child);
        walk_cell(w, &below, first + child);
    }
}

uint32_t rsv_face_walk_cells(rsv_face_walk *w, uint32_t face, uint32_t grid_level, uint32_t first)
{
    w->grid_level = grid_level;
    w->grid = first;
    w->next = first + (1u << 2 * grid_level);
    rsv_cell cell = first_cell(w, face);
    do {
        refined_cell at = coarse_cell(w, cell);
        walk_cell(w, &at, RSV_NONE);
    } while (advance(&cell));
    return w->next;
}

// ---- grids --------------------------------------------------------------------------------------

/// @param split [RSV_MAX_LEVEL + 1] cells of each level that are split, added to
static void count_split(const rsv_face_walk *w, const refined_cell *at, uint32_t *split)
{
    if (!is_split(w, at)) return;
    split[at->cell.level]++;
    for (uint32_t child = 0; child < 4; child++) {
        refined_cell below = child_of(w, at, child);
        count_split(w, &below, split);
    }
}

uint32_t rsv_face_grid_level(const rsv_face_walk *w, uint32_t face)
{
    uint32_t split[RSV_MAX_LEVEL + 1] = { 0 };
    rsv_cell cell = first_cell(w, face);
    uint32_t level = cell.level;
    do {
        refined_cell at = coarse_cell(w, cell);
        count_split(w, &at, split);
    } while (advance(&cell));
    while (level < RSV_MAX_LEVEL && split[level] == 1u << 2 * level)
        level++;
    return level;
}
