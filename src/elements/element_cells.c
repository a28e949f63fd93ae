/// Faces, their grids and the 4-to-1 subdivision of cells.
#include "elements_internal.h"

#include "../core/parallel.h"
#include "known_cells.h"
#include "open_corners.h"
#include "weld.h"

#include <string.h>

bool rsv_side_scatters(const rsv_bsdf *bsdf, bool back)
{
    return bsdf->diffuse > 0 && (!back || (bsdf->double_sided && !bsdf->solid));
}

rsv_status rsv_elements_create_faces(rsv_elements *e)
{
    const rsv_scene_view *scene = e->scene;
    rsv_context *context = e->context;
    for (int side = 0; side < 2; side++) {
        e->face_of[side] = rsv_alloc(context, scene->triangle_count, sizeof(uint32_t));
        if (!e->face_of[side]) return RSV_ERROR_MEMORY;
        for (size_t t = 0; t < scene->triangle_count; t++) {
            bool scatters = rsv_side_scatters(&e->bsdf[scene->triangle_material[t]], side);
            e->face_of[side][t] = scatters ? (uint32_t)e->face_count++ : RSV_NONE;
        }
    }
    e->face_triangle = rsv_alloc(context, e->face_count, sizeof *e->face_triangle);
    e->face_back = rsv_alloc(context, e->face_count, sizeof *e->face_back);
    e->face_level = rsv_alloc(context, e->face_count, sizeof *e->face_level);
    e->face_halvings = rsv_alloc(context, e->face_count, sizeof *e->face_halvings);
    e->face_slot = rsv_alloc(context, e->face_count, sizeof *e->face_slot);
    e->face_area = rsv_alloc(context, e->face_count, sizeof *e->face_area);
    e->face_corner = rsv_alloc(context, e->face_count, sizeof *e->face_corner);
    e->face_edge = rsv_alloc(context, e->face_count, sizeof *e->face_edge);
    if (!e->face_triangle || !e->face_back || !e->face_level || !e->face_halvings ||
        !e->face_slot || !e->face_area || !e->face_corner || !e->face_edge)
        return RSV_ERROR_MEMORY;
    for (int side = 0; side < 2; side++) {
        for (size_t t = 0; t < scene->triangle_count; t++) {
            uint32_t face = e->face_of[side][t];
            if (face == RSV_NONE) continue;
            e->face_triangle[face] = (uint32_t)t;
            e->face_back[face] = (uint8_t)side;
            e->face_area[face] = rsv_triangle_area(scene, (uint32_t)t);
        }
    }
    return rsv_weld_faces(e);
}

rsv_status rsv_elements_copy_faces(const rsv_elements *from, rsv_elements *to)
{
    rsv_context *context = to->context;
    to->face_count = from->face_count;
#define COPY_ARRAY(field, count)                                                                   \
    do {                                                                                           \
        to->field = rsv_alloc(context, count, sizeof *to->field);                                  \
        if (!to->field) return RSV_ERROR_MEMORY;                                                   \
        memcpy(to->field, from->field, (count) * sizeof *to->field);                               \
    } while (0)
    COPY_ARRAY(face_of[0], to->scene->triangle_count);
    COPY_ARRAY(face_of[1], to->scene->triangle_count);
    COPY_ARRAY(face_triangle, to->face_count);
    COPY_ARRAY(face_back, to->face_count);
    COPY_ARRAY(face_level, to->face_count);
    COPY_ARRAY(face_halvings, to->face_count);
    COPY_ARRAY(face_slot, to->face_count);
    COPY_ARRAY(face_area, to->face_count);
    COPY_ARRAY(face_corner, to->face_count);
    COPY_ARRAY(face_edge, to->face_count);
#undef COPY_ARRAY
    return RSV_OK;
}

/// Level of a face's regular grid: that of its largest cell.
static uint8_t grid_level(const rsv_elements *e, const rsv_spacing *spacing, size_t face)
{
    if (!spacing->scene)
        return (uint8_t)rsv_spacing_level(e->scene, e->face_triangle[face], spacing->metres);
    const rsv_known_cells *known = spacing->scene->known_cells;
    uint8_t level; // where cells have other grids to lie in, random numbers of nodes are others too
    if (known && known->grid_level(known->user, e, (uint32_t)face, &level)) return level;
    return (uint8_t)rsv_spacing_divide(spacing, e->face_triangle[face], e->face_back[face])
        .coarsest;
}

typedef struct grid_job {
    rsv_elements *e;
    const rsv_spacing *spacing;
} grid_job;

static void choose_levels(void *user, rsv_span span)
{
    const grid_job *job = user;
    for (size_t face = span.begin; face < span.end; face++)
        job->e->face_level[face] = grid_level(job->e, job->spacing, face);
}

rsv_status rsv_elements_create_grid(rsv_elements *e, const rsv_spacing *spacing)
{
    size_t count = 0;
    grid_job job = { e, spacing };
    rsv_parallel_for(e->context, e->face_count, 256, choose_levels, &job);
    for (size_t face = 0; face < e->face_count; face++) {
        e->face_slot[face] = (uint32_t)count;
        count += (size_t)1 << (2 * e->face_level[face]);
        if (count >= RSV_SLOT_SPLIT)
            return rsv_fail(
                RSV_ERROR_MEMORY, "elements: more than 2^31 cells; ask for fewer elements");
    }
    e->slot_count = e->cell_count = count;
    e->slot = rsv_alloc(e->context, count, sizeof *e->slot);
    e->cell = rsv_alloc(e->context, count, sizeof *e->cell);
    if (!e->slot || !e->cell) return RSV_ERROR_MEMORY;
    size_t next = 0;
    for (size_t face = 0; face < e->face_count; face++) {
        int side = 1 << e->face_level[face];
        for (int j = 0; j < side; j++) {
            for (int n = 0; n < 2 * (side - j) - 1; n++, next++) {
                e->slot[next] = (uint32_t)next;
                e->cell[next] = (rsv_cell){ (uint32_t)face, (uint16_t)(n / 2), (uint16_t)j,
                    e->face_level[face], (uint8_t)(n & 1) };
            }
        }
    }
    return RSV_OK;
}

rsv_cell rsv_child_cell(rsv_cell parent, int k)
{
    rsv_cell child = parent;
    child.level++;
    int i = 2 * parent.i, j = 2 * parent.j;
    if (!parent.flipped) {
        i += k == 1;
        j += k == 2;
    } else {
        i += k == 0 || k == 2 || k == 3;
        j += k == 0 || k == 1 || k == 3;
    }
    child.i = (uint16_t)i;
    child.j = (uint16_t)j;
    child.flipped = k == 3 ? !parent.flipped : parent.flipped;
    return child;
}

typedef struct splitter {
    const rsv_elements *old;
    const uint8_t *split;
    rsv_elements *fresh;
    size_t next_slot, next_cell;
} splitter;

static void emit_cell(splitter *s, size_t slot, rsv_cell cell)
{
    s->fresh->cell[s->next_cell] = cell;
    s->fresh->slot[slot] = (uint32_t)s->next_cell++;
}

/// Known openness of a cell that is split.
static uint8_t known_openness(const rsv_elements *e, size_t slot)
{
    uint32_t content = e->slot[slot];
    if (content & RSV_SLOT_SPLIT) return e->slot_openness ? e->slot_openness[slot] : 0;
    return e->cell_openness ? RSV_OPENNESS_KNOWN | e->cell_openness[content] : 0;
}

static void emit_slot(splitter *s, size_t old_slot, size_t slot)
{
    uint32_t content = s->old->slot[old_slot];
    bool was_split = content & RSV_SLOT_SPLIT;
    if (!was_split && !s->split[content]) {
        emit_cell(s, slot, s->old->cell[content]);
        return;
    }
    size_t first = s->next_slot;
    s->next_slot += 4;
    s->fresh->slot[slot] = RSV_SLOT_SPLIT | (uint32_t)first;
    s->fresh->slot_openness[slot] = known_openness(s->old, old_slot);
    for (size_t k = 0; k < 4; k++) {
        if (was_split)
            emit_slot(s, (content & ~RSV_SLOT_SPLIT) + k, first + k);
        else
            emit_cell(s, first + k, rsv_child_cell(s->old->cell[content], (int)k));
    }
}

rsv_status rsv_elements_split_cells(
    const rsv_elements *old, const uint8_t *split, rsv_elements *fresh)
{
    size_t marked = 0, grid = 0;
    for (size_t c = 0; c < old->cell_count; c++)
        marked += split[c] != 0;
    for (size_t face = 0; face < old->face_count; face++)
        grid += (size_t)1 << (2 * old->face_level[face]);
    fresh->cell_count = old->cell_count + 3 * marked;
    fresh->slot_count = old->slot_count + 4 * marked;
    if (fresh->slot_count >= RSV_SLOT_SPLIT)
        return rsv_fail(RSV_ERROR_MEMORY, "elements: more than 2^31 cells; ask for fewer elements");
    fresh->cell = rsv_alloc(fresh->context, fresh->cell_count, sizeof *fresh->cell);
    fresh->slot = rsv_alloc(fresh->context, fresh->slot_count, sizeof *fresh->slot);
    fresh->slot_openness = rsv_alloc(fresh->context, fresh->slot_count, 1);
    if (!fresh->cell || !fresh->slot || !fresh->slot_openness) return RSV_ERROR_MEMORY;
    splitter s = { old, split, fresh, grid, 0 };
    for (size_t slot = 0; slot < grid; slot++)
        emit_slot(&s, slot, slot);
    return RSV_OK;
}
