#include "light_table.h"

#include "../render/camera_chain.h"

#include <string.h>

/// Fields that add up to what is shown, each on its own elements.
#define MAX_FIELDS 4
typedef struct stored_field {
    const rsv_elements *elements;
    const rsv_rgb *value; ///< [node_count]
} stored_field;

typedef struct field_sum {
    stored_field part[MAX_FIELDS];
    int count;
} field_sum;

static void add_field(field_sum *sum, const rsv_elements *elements, const rsv_rgb *value)
{
    if (elements && value) sum->part[sum->count++] = (stored_field){ elements, value };
}

static void add_direct(field_sum *sum, const rsv_solution *s)
{
    if (!s->fine.direct) {
        add_field(sum, s->elements, s->source);
        return;
    }
    add_field(sum, s->elements, s->gathered);
    add_field(sum, s->caustics.elements, s->caustics.caustic);
    add_field(sum, s->fine.elements, s->fine.direct);
}

static field_sum shown_fields(const rsv_solution *s, uint32_t layer)
{
    field_sum sum = { .count = 0 };
    if (layer == RSV_NONE || layer == 1) add_direct(&sum, s);
    if (layer == RSV_NONE) add_field(&sum, s->elements, s->indirect);
    if (layer > 1 && layer - 1 < s->order_count) add_field(&sum, s->elements, s->order[layer - 1]);
    return sum;
}

// ---- the common refinement ----------------------------------------------------------------------

/// Where the levels of a solution are split; what is not there counts as whole.
#define LEVELS 3
typedef struct level_slots {
    uint32_t slot[LEVELS];
} level_slots;

/// The walk over the common refinement of one face.
typedef struct face_walk {
    const rsv_elements *level[LEVELS]; ///< the coarse one first; NULL = not there
    const field_sum *fields;
    rsv_rgb scale, offset; ///< radiance = offset + scale * irradiance
    rsv_light_cell *cell;  ///< all cells, or NULL to count them only
    uint32_t next;         ///< first cell that is not in use yet
} face_walk;

static void cell_weights(const rsv_cell *cell, float u, float v, float weight[3])
{
    float side = (float)(1 << cell->level);
    float x = u * side - cell->i, y = v * side - cell->j;
    weight[0] = cell->flipped ? x + y - 1 : 1 - x - y;
    weight[1] = cell->flipped ? 1 - x : x;
    weight[2] = cell->flipped ? 1 - y : y;
}

static uint32_t slot_of(const face_walk *w, const level_slots *at, const rsv_elements *elements)
{
    for (int k = 0; k < LEVELS; k++)
        if (w->level[k] == elements) return at->slot[k];
    return at->slot[0];
}

static rsv_rgb irradiance_at(const face_walk *w, const level_slots *at, const float place[2])
{
    rsv_rgb sum = rgb_gray(0);
    for (int f = 0; f < w->fields->count; f++) {
        const stored_field *part = &w->fields->part[f];
        uint32_t cell = slot_of(w, at, part->elements);
        float weight[3];
        cell_weights(&part->elements->cell[cell], place[0], place[1], weight);
        for (int k = 0; k < 3; k++)
            sum = rgb_mad(sum, weight[k], part->value[part->elements->cell_node[cell][k]]);
    }
    return sum;
}

static void fill_cell(
    const face_walk *w, uint32_t index, const level_slots *at, const float corner[3][2])
{
    for (int k = 0; k < 3; k++) {
        rsv_rgb shown = rgb_add(w->offset, rgb_mul(w->scale, irradiance_at(w, at, corner[k])));
        float *out = w->cell[index].corner[k];
        out[0] = shown.r, out[1] = shown.g, out[2] = shown.b, out[3] = 0;
    }
}

/// Corners of child `child`: the cell's own corner and the middles next to it, or the three middles.
static void child_corners(const float corner[3][2], int child, float out[3][2])
{
    for (int k = 0; k < 3; k++)
        for (int axis = 0; axis < 2; axis++) {
            int a = child < 3 ? child : (k + 1) % 3, b = child < 3 ? k : (k + 2) % 3;
            out[k][axis] = 0.5f * (corner[a][axis] + corner[b][axis]);
        }
}

static level_slots child_slots(const face_walk *w, const level_slots *at, uint32_t child)
{
    level_slots below = *at;
    for (int k = 0; k < LEVELS; k++)
        if (w->level[k] && (at->slot[k] & RSV_SLOT_SPLIT))
            below.slot[k] = w->level[k]->slot[(at->slot[k] & ~RSV_SLOT_SPLIT) + child];
    return below;
}

static void walk_cell(face_walk *w, uint32_t index, const level_slots *at, const float corner[3][2])
{
    uint32_t split = 0;
    for (int k = 0; k < LEVELS; k++)
        split |= w->level[k] ? at->slot[k] & RSV_SLOT_SPLIT : 0;
    if (!split) {
        if (w->cell) fill_cell(w, index, at, corner);
        return;
    }
    uint32_t first = w->next;
    w->next += 4;
    if (w->cell) memcpy(&w->cell[index].corner[0][3], &first, sizeof first);
    for (uint32_t child = 0; child < 4; child++) {
        float below[3][2];
        child_corners(corner, (int)child, below);
        level_slots slots = child_slots(w, at, child);
        walk_cell(w, first + child, &slots, below);
    }
}

/// @param first cell of the face's grid @return the cell after its last one
static uint32_t walk_face(face_walk *w, uint32_t face, uint32_t first)
{
    const rsv_elements *e = w->level[0];
    uint32_t level = e->face_level[face], side = 1u << level, index = 0;
    w->next = first + side * side;
    for (uint32_t j = 0; j < side; j++)
        for (uint32_t i = 0; i < side - j; i++)
            for (uint32_t flipped = 0; flipped < 2; flipped++) {
                if (flipped && i + j == side - 1) continue;
                rsv_cell cell = { face, (uint16_t)i, (uint16_t)j, (uint8_t)level,
                    (uint8_t)flipped };
                float corner[3][2];
                for (int k = 0; k < 3; k++)
                    rsv_cell_corner(&cell, k, &corner[k][0], &corner[k][1]);
                level_slots at = { { 0 } };
                for (int k = 0; k < LEVELS; k++)
                    if (w->level[k])
                        at.slot[k] = w->level[k]->slot[w->level[k]->face_slot[face] + index];
                walk_cell(w, first + index++, &at, corner);
            }
    return w->next;
}

static face_walk begin_walk(const rsv_solution *s)
{
    return (face_walk){ .level = { s->elements, s->fine.elements, s->caustics.elements } };
}

// ---- sides --------------------------------------------------------------------------------------

static bool is_stored(const rsv_solution *s, uint32_t material)
{
    const rsv_bsdf *bsdf = &s->bsdf[material];
    bool translucent = s->diffused.material && s->diffused.material[material];
    return bsdf->lambert && bsdf->opacity >= 1 && !translucent &&
           !s->scene.view->material_varies[material];
}

/// Cells before those of faces: a black one, then one for the emission of each material.
static uint32_t first_face_cell(const rsv_solution *s)
{
    return 1 + (uint32_t)s->scene.view->material_count;
}

static rsv_shown_side shown_side(const rsv_light_table *t, uint32_t triangle, bool back)
{
    const rsv_solution *s = t->solution;
    uint32_t material = s->scene.view->triangle_material[triangle];
    uint32_t face = s->elements->face_of[back][triangle];
    if (!is_stored(s, material)) return (rsv_shown_side){ 0, 0, RSV_SHOWN_CHAIN };
    if (back && !s->bsdf[material].double_sided) return (rsv_shown_side){ 0, 0, RSV_SHOWN_STORED };
    if (face == RSV_NONE) return (rsv_shown_side){ 1 + material, 0, RSV_SHOWN_STORED };
    return (rsv_shown_side){ t->face_cell[face], s->elements->face_level[face], RSV_SHOWN_STORED };
}

static void fill_sides(rsv_light_table *t)
{
    for (int back = 0; back < 2; back++) {
        for (uint32_t k = 0; k < t->triangle_count; k++)
            t->side[k][back] = shown_side(t, k, back);
        bool sky = t->solution->lights->environment != NULL;
        t->side[t->triangle_count][back] =
            (rsv_shown_side){ 0, 0, sky ? RSV_SHOWN_SKY : RSV_SHOWN_STORED };
    }
}

static bool face_is_stored(const rsv_solution *s, uint32_t face)
{
    return is_stored(s, s->scene.view->triangle_material[s->elements->face_triangle[face]]);
}

/// Faces of other kinds take no cells.
static rsv_status number_cells(rsv_light_table *t)
{
    const rsv_solution *s = t->solution;
    face_walk walk = begin_walk(s);
    uint32_t next = first_face_cell(s);
    for (uint32_t face = 0; face < s->elements->face_count; face++) {
        t->face_cell[face] = next;
        if (face_is_stored(s, face)) next = walk_face(&walk, face, next);
        if (next > UINT32_MAX / 2)
            return rsv_fail(RSV_ERROR_UNSUPPORTED, "frames: the scene has too many light cells");
    }
    t->face_cell[s->elements->face_count] = next;
    t->cell_count = next;
    return RSV_OK;
}

rsv_status rsv_light_table_create(const rsv_solution *s, rsv_light_table *t)
{
    rsv_status status = RSV_ERROR_MEMORY;
    *t = (rsv_light_table){ .context = s->context, .solution = s };
    t->triangle_count = (uint32_t)s->scene.view->triangle_count;
    t->face_cell = rsv_alloc(s->context, s->elements->face_count + 1, sizeof *t->face_cell);
    t->side = rsv_alloc(s->context, (size_t)t->triangle_count + 1, sizeof *t->side);
    if (!t->face_cell || !t->side) goto cleanup;
    RSV_TRY(number_cells(t));
    status = RSV_ERROR_MEMORY;
    t->cell = rsv_alloc(s->context, t->cell_count, sizeof *t->cell);
    if (!t->cell) goto cleanup;
    fill_sides(t);
    rsv_light_table_bake(t, RSV_NONE);
    return RSV_OK;
cleanup:
    rsv_light_table_destroy(t);
    return status;
}

void rsv_light_table_destroy(rsv_light_table *t)
{
    if (!t->context) return;
    rsv_free(t->context, t->side);
    rsv_free(t->context, t->face_cell);
    rsv_free(t->context, t->cell);
    *t = (rsv_light_table){ 0 };
}

static void bake_emission(rsv_light_table *t)
{
    const rsv_bsdf *bsdf = t->solution->bsdf;
    for (uint32_t m = 0; m < t->solution->scene.view->material_count; m++) {
        bool shows = rsv_shows_emission(t) && (bsdf[m].emissive || bsdf[m].unlit);
        rsv_rgb e = shows ? bsdf[m].emission : rgb_gray(0);
        for (int k = 0; k < 3; k++)
            memcpy(t->cell[1 + m].corner[k], &e, sizeof e);
    }
}

void rsv_light_table_bake(rsv_light_table *t, uint32_t layer)
{
    const rsv_solution *s = t->solution;
    t->layer = layer;
    bake_emission(t);
    field_sum fields = shown_fields(s, layer);
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(t->context))
    for (uint32_t face = 0; face < s->elements->face_count; face++) {
        if (!face_is_stored(s, face)) continue;
        uint32_t material = s->scene.view->triangle_material[s->elements->face_triangle[face]];
        face_walk walk = begin_walk(s);
        walk.fields = &fields;
        walk.cell = t->cell;
        walk.scale = rgb_scale(s->bsdf[material].exitance_albedo, 1 / RSV_PI);
        memcpy(&walk.offset, t->cell[1 + material].corner[0], sizeof walk.offset);
        walk_face(&walk, face, t->face_cell[face]);
    }
}

// ---- surfaces that are not in the table ----------------------------------------------------------

static rsv_rgb indirect_at(const rsv_solution *s, uint32_t face, float u, float v, uint32_t order)
{
    if (rsv_is_translucent(s, face)) return rsv_solution_diffused(s, face, u, v, order);
    const rsv_rgb *field = order == RSV_NONE ? s->indirect : s->order[order];
    return rsv_elements_interpolate(s->elements, field, face, u, v);
}

rsv_rgb rsv_shown_irradiance(const rsv_light_table *t, uint32_t face, float u, float v)
{
    const rsv_solution *s = t->solution;
    rsv_rgb sum = rgb_gray(0);
    if (t->layer == RSV_NONE || t->layer == 1)
        sum = rsv_is_translucent(s, face) ? rsv_solution_diffused_direct(s, face, u, v)
                                          : rsv_solution_direct(s, face, u, v, false);
    if (t->layer == RSV_NONE) sum = rgb_add(sum, indirect_at(s, face, u, v, RSV_NONE));
    if (t->layer != RSV_NONE && t->layer > 1 && t->layer - 1 < s->order_count)
        sum = indirect_at(s, face, u, v, t->layer - 1);
    return sum;
}
