#include "elements.h"

#include "../core/index_map.h"
#include "weld.h"

#include <string.h>

#define LATTICE (1u << RSV_MAX_LEVEL) ///< side of the finest barycentric lattice

float rsv_triangle_area(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 e1 = v3_sub(scene->position[corner[1]], a), e2 = v3_sub(scene->position[corner[2]], a);
    return 0.5f * v3_length(v3_cross(e1, e2));
}

rsv_surface_point rsv_surface_point_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]], b = scene->position[corner[1]];
    rsv_vec3 c = scene->position[corner[2]];
    rsv_surface_point point;
    point.position = v3_barycentric(a, b, c, u, v);
    point.geometric = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    point.normal = v3_normalize(v3_barycentric(
        scene->normal[corner[0]], scene->normal[corner[1]], scene->normal[corner[2]], u, v));
    if (v3_dot(point.normal, point.geometric) <= 0) point.normal = point.geometric;
    if (back) {
        point.geometric = v3_neg(point.geometric);
        point.normal = v3_neg(point.normal);
    }
    point.extent = f_max(v3_max_abs(a), f_max(v3_max_abs(b), v3_max_abs(c)));
    return point;
}

// ---- faces --------------------------------------------------------------------------------------

static bool side_scatters(const rsv_bsdf *bsdf, bool back)
{
    return bsdf->diffuse > 0 && (!back || (bsdf->double_sided && !bsdf->solid));
}

static rsv_status create_faces(rsv_elements *e)
{
    const rsv_scene_view *scene = e->scene;
    rsv_context *context = e->context;
    for (int side = 0; side < 2; side++) {
        e->face_of[side] = rsv_alloc(context, scene->triangle_count, sizeof(uint32_t));
        if (!e->face_of[side]) return RSV_ERROR_MEMORY;
        for (size_t t = 0; t < scene->triangle_count; t++) {
            bool scatters = side_scatters(&e->bsdf[scene->triangle_material[t]], side);
            e->face_of[side][t] = scatters ? (uint32_t)e->face_count++ : RSV_NONE;
        }
    }
    e->face_triangle = rsv_alloc(context, e->face_count, sizeof *e->face_triangle);
    e->face_back = rsv_alloc(context, e->face_count, sizeof *e->face_back);
    e->face_level = rsv_alloc(context, e->face_count, sizeof *e->face_level);
    e->face_slot = rsv_alloc(context, e->face_count, sizeof *e->face_slot);
    e->face_area = rsv_alloc(context, e->face_count, sizeof *e->face_area);
    e->face_corner = rsv_alloc(context, e->face_count, sizeof *e->face_corner);
    e->face_edge = rsv_alloc(context, e->face_count, sizeof *e->face_edge);
    if (!e->face_triangle || !e->face_back || !e->face_level || !e->face_slot || !e->face_area ||
        !e->face_corner || !e->face_edge)
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

static rsv_status copy_faces(const rsv_elements *from, rsv_elements *to)
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
    COPY_ARRAY(face_slot, to->face_count);
    COPY_ARRAY(face_area, to->face_count);
    COPY_ARRAY(face_corner, to->face_count);
    COPY_ARRAY(face_edge, to->face_count);
#undef COPY_ARRAY
    return RSV_OK;
}

// ---- cells --------------------------------------------------------------------------------------

/// Grid level at which a face's cells are about `spacing` long. Slivers count by a quarter of their
/// length, or their cells would be far too many across.
static uint8_t grid_level(const rsv_scene_view *scene, uint32_t triangle, float spacing)
{
    const uint32_t *corner = scene->triangle[triangle];
    float longest = 0;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 edge = v3_sub(scene->position[corner[k]], scene->position[corner[(k + 1) % 3]]);
        longest = f_max(longest, v3_length(edge));
    }
    float size = f_max(1.4f * sqrtf(2 * rsv_triangle_area(scene, triangle)), 0.25f * longest);
    int level = (int)ceilf(log2f(f_max(size / (1.4f * spacing), 1e-6f)) - 0.5f);
    return (uint8_t)(level < 0 ? 0 : level > 10 ? 10 : level);
}

static rsv_status create_grid(rsv_elements *e, float spacing)
{
    size_t count = 0;
    for (size_t face = 0; face < e->face_count; face++) {
        e->face_level[face] = grid_level(e->scene, e->face_triangle[face], spacing);
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

/// The k-th child: 0..2 keep a corner of the parent, 3 is the middle one, turned over.
static rsv_cell child_cell(rsv_cell parent, int k)
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
    for (size_t k = 0; k < 4; k++) {
        if (was_split)
            emit_slot(s, (content & ~RSV_SLOT_SPLIT) + k, first + k);
        else
            emit_cell(s, first + k, child_cell(s->old->cell[content], (int)k));
    }
}

static rsv_status split_cells(const rsv_elements *old, const uint8_t *split, rsv_elements *fresh)
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
    if (!fresh->cell || !fresh->slot) return RSV_ERROR_MEMORY;
    splitter s = { old, split, fresh, grid, 0 };
    for (size_t slot = 0; slot < grid; slot++)
        emit_slot(&s, slot, slot);
    return RSV_OK;
}

// ---- nodes --------------------------------------------------------------------------------------

/// Position of a node on a face's finest lattice.
typedef struct lattice_point {
    uint32_t i, j;
} lattice_point;

static lattice_point corner_point(const rsv_cell *cell, int k)
{
    int shift = RSV_MAX_LEVEL - cell->level;
    uint32_t di = cell->flipped ? k != 1 : k == 1, dj = cell->flipped ? k != 2 : k == 2;
    return (lattice_point){ (cell->i + di) << shift, (cell->j + dj) << shift };
}

static uint64_t edge_key(
    const rsv_elements *e, uint32_t face, int edge, int from, int to, uint32_t t)
{
    bool forward = e->face_corner[face][from] < e->face_corner[face][to];
    return 1ull << 62 | (uint64_t)e->face_edge[face][edge] << 15 | (forward ? t : LATTICE - t);
}

/// Identity of a lattice point: faces that share a welded corner or edge give it the same key.
static uint64_t node_key(const rsv_elements *e, uint32_t face, lattice_point p)
{
    const uint32_t *corner = e->face_corner[face];
    if (p.i == 0 && p.j == 0) return corner[0];
    if (p.i == LATTICE) return corner[1];
    if (p.j == LATTICE) return corner[2];
    if (p.j == 0) return edge_key(e, face, 0, 0, 1, p.i);
    if (p.i == 0) return edge_key(e, face, 1, 0, 2, p.j);
    if (p.i + p.j == LATTICE) return edge_key(e, face, 2, 1, 2, p.j);
    return 2ull << 62 | (uint64_t)face << 28 | (uint64_t)p.i << 14 | p.j;
}

static rsv_status number_nodes(rsv_elements *e, rsv_index_map *nodes)
{
    e->cell_node = rsv_alloc(e->context, e->cell_count, sizeof *e->cell_node);
    if (!e->cell_node) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++) {
        for (int k = 0; k < 3; k++) {
            uint64_t key = node_key(e, e->cell[c].face, corner_point(&e->cell[c], k));
            uint32_t node = rsv_index_map_insert(nodes, key, (uint32_t)nodes->count);
            if (node == UINT32_MAX) return RSV_ERROR_MEMORY;
            e->cell_node[c][k] = node;
        }
    }
    e->node_count = nodes->count;
    return RSV_OK;
}

typedef struct hanging_finder {
    rsv_elements *e;
    const rsv_index_map *nodes;
    size_t capacity;
    uint8_t *unbalanced; ///< [cell_count] edge halved more than once
    bool any_unbalanced;
} hanging_finder;

static rsv_status add_hanging(
    hanging_finder *f, uint32_t node, uint32_t a, uint32_t b, float weight)
{
    rsv_elements *e = f->e;
    if (e->node_hanging[node] != RSV_NONE) return RSV_OK; // an edge shared by more than two faces
    rsv_status status = rsv_grow(
        e->context, (void **)&e->hanging, &f->capacity, e->hanging_count + 1, sizeof *e->hanging);
    if (status != RSV_OK) return status;
    e->node_hanging[node] = (uint32_t)e->hanging_count;
    e->hanging[e->hanging_count++] = (rsv_hanging){ node, { a, b }, weight };
    return RSV_OK;
}

/// Nodes strictly between p and q on one edge of `cell`, by bisection.
static rsv_status find_between(hanging_finder *f, uint32_t cell, uint32_t a, uint32_t b,
    lattice_point p, lattice_point q, float t0, float t1, int depth)
{
    lattice_point m = { (p.i + q.i) / 2, (p.j + q.j) / 2 };
    if ((p.i == m.i && p.j == m.j) || (q.i == m.i && q.j == m.j)) return RSV_OK;
    uint32_t node = rsv_index_map_find(f->nodes, node_key(f->e, f->e->cell[cell].face, m));
    if (node == UINT32_MAX) return RSV_OK;
    if (depth > 0) {
        f->unbalanced[cell] = 1;
        f->any_unbalanced = true;
    }
    float t = 0.5f * (t0 + t1);
    rsv_status status = add_hanging(f, node, a, b, t);
    if (status == RSV_OK) status = find_between(f, cell, a, b, p, m, t0, t, depth + 1);
    if (status == RSV_OK) status = find_between(f, cell, a, b, m, q, t, t1, depth + 1);
    return status;
}

/// Cells are visited from coarse to fine, so that parents come before their children.
static rsv_status find_hanging(hanging_finder *f)
{
    rsv_elements *e = f->e;
    e->node_hanging = rsv_alloc(e->context, e->node_count, sizeof *e->node_hanging);
    f->unbalanced = rsv_alloc(e->context, e->cell_count, 1);
    if (!e->node_hanging || !f->unbalanced) return RSV_ERROR_MEMORY;
    memset(e->node_hanging, 0xff, e->node_count * sizeof *e->node_hanging);
    int coarsest = RSV_MAX_LEVEL, finest = 0;
    for (size_t c = 0; c < e->cell_count; c++) {
        coarsest = e->cell[c].level < coarsest ? e->cell[c].level : coarsest;
        finest = e->cell[c].level > finest ? e->cell[c].level : finest;
    }
    for (int level = coarsest; level <= finest; level++) {
        for (size_t c = 0; c < e->cell_count; c++) {
            if (e->cell[c].level != level) continue;
            for (int k = 0; k < 3; k++) {
                int l = (k + 1) % 3;
                rsv_status status =
                    find_between(f, (uint32_t)c, e->cell_node[c][k], e->cell_node[c][l],
                        corner_point(&e->cell[c], k), corner_point(&e->cell[c], l), 0, 1, 0);
                if (status != RSV_OK) return status;
            }
        }
    }
    return RSV_OK;
}

// ---- supports -----------------------------------------------------------------------------------

static float cell_area(const rsv_elements *e, uint32_t cell)
{
    return e->face_area[e->cell[cell].face] / (float)(1u << (2 * e->cell[cell].level));
}

static rsv_status create_supports(rsv_elements *e)
{
    e->node_face = rsv_alloc(e->context, e->node_count, sizeof *e->node_face);
    e->node_area = rsv_alloc(e->context, e->node_count, sizeof *e->node_area);
    e->support_begin = rsv_alloc(e->context, e->node_count + 1, sizeof *e->support_begin);
    e->support = rsv_alloc(e->context, 3 * e->cell_count, sizeof *e->support);
    if (!e->node_face || !e->node_area || !e->support_begin || !e->support) return RSV_ERROR_MEMORY;
    if (e->cell_count >= RSV_NONE / 4)
        return rsv_fail(RSV_ERROR_MEMORY, "elements: more than 2^30 cells; ask for fewer elements");
    for (size_t c = 0; c < e->cell_count; c++)
        for (int k = 0; k < 3; k++)
            e->support_begin[e->cell_node[c][k] + 1]++;
    for (size_t n = 0; n < e->node_count; n++)
        e->support_begin[n + 1] += e->support_begin[n];
    for (size_t c = e->cell_count; c-- > 0;) {
        for (int k = 0; k < 3; k++) {
            uint32_t node = e->cell_node[c][k];
            // filled from the back, so that support_begin ends up where it started
            e->support[--e->support_begin[node + 1]] = (uint32_t)(4 * c) + (uint32_t)k;
            e->node_area[node] += cell_area(e, (uint32_t)c) / 3;
            e->node_face[node] = e->cell[c].face;
        }
    }
    for (size_t n = 0; n < e->node_count; n++) // undo the shift by one
        e->support_begin[n] = e->support_begin[n + 1];
    e->support_begin[e->node_count] = (uint32_t)(3 * e->cell_count);
    for (size_t h = e->hanging_count; h-- > 0;) {
        const rsv_hanging *hanging = &e->hanging[h];
        float area = e->node_area[hanging->node];
        e->node_area[hanging->parent[0]] += (1 - hanging->weight) * area;
        e->node_area[hanging->parent[1]] += hanging->weight * area;
        e->node_area[hanging->node] = 0;
    }
    return RSV_OK;
}

rsv_status rsv_elements_renumber(rsv_elements *e, size_t node_count)
{
    uint32_t *node_hanging = rsv_alloc(e->context, node_count, sizeof *node_hanging);
    if (!node_hanging) return RSV_ERROR_MEMORY;
    memset(node_hanging, 0xff, node_count * sizeof *node_hanging);
    memcpy(node_hanging, e->node_hanging, e->node_count * sizeof *node_hanging);
    rsv_free(e->context, e->node_hanging);
    rsv_free(e->context, e->node_face);
    rsv_free(e->context, e->node_area);
    rsv_free(e->context, e->support_begin);
    rsv_free(e->context, e->support);
    e->node_face = NULL;
    e->node_area = NULL;
    e->support_begin = e->support = NULL;
    e->node_hanging = node_hanging;
    e->node_count = node_count;
    return create_supports(e);
}

/// Barycentric weight of a corner with density proportional to itself over a triangle: the inverse of the
/// distribution function 3 b^2 - 2 b^3.
static float sample_hat(float x) { return 0.5f - sinf(asinf(1 - 2 * x) / 3); }

/// The place on the face where the hat function of a cell's corner k has weight b, and the next corner c.
static rsv_support_point place_in_cell(const rsv_elements *e, uint32_t support, float b, float c)
{
    const rsv_cell *cell = &e->cell[support / 4];
    int k = (int)(support & 3);
    float u0, v0, u1, v1, u2, v2, rest = 1 - b - c;
    rsv_cell_corner(cell, k, &u0, &v0);
    rsv_cell_corner(cell, (k + 1) % 3, &u1, &v1);
    rsv_cell_corner(cell, (k + 2) % 3, &u2, &v2);
    return (rsv_support_point){ support, b * u0 + c * u1 + rest * u2, b * v0 + c * v1 + rest * v2 };
}

void rsv_elements_sample_support(
    const rsv_elements *e, uint32_t node, uint32_t count, uint32_t seed, rsv_support_point *points)
{
    uint32_t chosen = e->support_begin[node], end = e->support_begin[node + 1];
    uint32_t stream = rsv_hash2(seed, node);
    float total = 0;
    for (uint32_t s = chosen; s < end; s++)
        total += cell_area(e, e->support[s] / 4);
    float below = 0, area = cell_area(e, e->support[chosen] / 4);
    for (uint32_t k = 0; k < count; k++) {
        float jitter = rsv_unit_float(rsv_hash(stream + k));
        float target = total * ((float)k + jitter) / (float)count;
        while (chosen + 1 < end && target >= below + area) {
            below += area;
            area = cell_area(e, e->support[++chosen] / 4);
        }
        float x, y;
        rsv_sobol_2d(k, stream, &x, &y);
        float b = sample_hat(x);
        points[k] = place_in_cell(e, e->support[chosen], b, (1 - b) * y);
    }
}

void rsv_elements_constrain(const rsv_elements *elements, rsv_rgb *value)
{
    for (size_t h = 0; h < elements->hanging_count; h++) {
        const rsv_hanging *hanging = &elements->hanging[h];
        value[hanging->node] = rgb_mad(rgb_scale(value[hanging->parent[0]], 1 - hanging->weight),
            hanging->weight, value[hanging->parent[1]]);
    }
}

// ---- creation -----------------------------------------------------------------------------------

static rsv_status create_empty(const rsv_scene_view *scene, const rsv_bsdf *bsdf,
    rsv_context *context, rsv_elements **elements)
{
    rsv_elements *e = rsv_alloc(context, 1, sizeof *e);
    if (!e) return RSV_ERROR_MEMORY;
    e->context = context;
    e->scene = scene;
    e->bsdf = bsdf;
    *elements = e;
    return RSV_OK;
}

/// Numbers the nodes of finished cells; on return `unbalanced` (to be freed) marks cells to be split.
static rsv_status finish(rsv_elements *e, uint8_t **unbalanced, bool *any_unbalanced)
{
    rsv_status status;
    rsv_index_map nodes = { 0 };
    hanging_finder finder = { .e = e, .nodes = &nodes };
    RSV_TRY(rsv_index_map_create(e->context, e->cell_count * 2 / 3 + 16, &nodes));
    RSV_TRY(number_nodes(e, &nodes));
    RSV_TRY(find_hanging(&finder));
    RSV_TRY(create_supports(e));
    *any_unbalanced = finder.any_unbalanced;
cleanup:
    *unbalanced = finder.unbalanced;
    rsv_index_map_destroy(&nodes);
    return status;
}

static rsv_status refine_once(const rsv_elements *coarser, const uint8_t *split,
    rsv_elements **finer, uint8_t **unbalanced, bool *any_unbalanced)
{
    rsv_status status;
    rsv_elements *e = NULL;
    RSV_TRY(create_empty(coarser->scene, coarser->bsdf, coarser->context, &e));
    RSV_TRY(copy_faces(coarser, e));
    RSV_TRY(split_cells(coarser, split, e));
    RSV_TRY(finish(e, unbalanced, any_unbalanced));
    *finer = e;
    return RSV_OK;
cleanup:
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

rsv_status rsv_elements_create(
    const rsv_scene *scene, const rsv_bsdf *bsdf, float spacing, rsv_elements **elements)
{
    rsv_status status;
    rsv_elements *e = NULL;
    uint8_t *unbalanced = NULL;
    bool any_unbalanced = false;
    RSV_TRY(create_empty(rsv_scene_get_view(scene), bsdf, rsv_scene_get_context(scene), &e));
    RSV_TRY(create_faces(e));
    RSV_TRY(create_grid(e, spacing));
    status = finish(e, &unbalanced, &any_unbalanced);
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

void rsv_elements_destroy(rsv_elements *e)
{
    if (!e) return;
    rsv_context *context = e->context;
    void *arrays[] = { e->face_of[0], e->face_of[1], e->face_triangle, e->face_back, e->face_level,
        e->face_slot, e->face_area, e->face_corner, e->face_edge, e->slot, e->cell, e->cell_node,
        e->node_face, e->node_area, e->support_begin, e->support, e->hanging, e->node_hanging };
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        rsv_free(context, arrays[k]);
    rsv_free(context, e);
}

void rsv_elements_average(const rsv_elements *e, const rsv_rgb *value, rsv_rgb *average)
{
#pragma omp parallel for schedule(static) num_threads(rsv_threads(e->context))
    for (size_t node = 0; node < e->node_count; node++) {
        rsv_rgb sum = rgb_gray(0);
        float weight = 0;
        for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
            const uint32_t *corner = e->cell_node[e->support[s] / 4];
            uint32_t k = e->support[s] & 3;
            if (corner[k] != node) continue; // bridged
            float area = cell_area(e, e->support[s] / 4);
            sum = rgb_mad(sum, 0.5f * area, value[node]);
            sum = rgb_mad(sum, 0.25f * area, value[corner[(k + 1) % 3]]);
            sum = rgb_mad(sum, 0.25f * area, value[corner[(k + 2) % 3]]);
            weight += area;
        }
        average[node] = weight > 0 ? rgb_scale(sum, 1 / weight) : value[node];
    }
    rsv_elements_constrain(e, average);
}
