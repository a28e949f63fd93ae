/// Numbers the corners of cells, finds those that hang, and collects the cells around each.
#include "elements_internal.h"

#include "../core/index_map.h"

#include <string.h>

#define LATTICE (1u << RSV_MAX_LEVEL) ///< side of the finest barycentric lattice

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

#define BETWEEN_CORNERS (1ull << 62) ///< the least key that is not a corner's

static uint64_t edge_key(
    const rsv_elements *e, uint32_t face, int edge, int from, int to, uint32_t t)
{
    bool forward = e->face_corner[face][from] < e->face_corner[face][to];
    return BETWEEN_CORNERS | (uint64_t)e->face_edge[face][edge] << 15 | (forward ? t : LATTICE - t);
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

/// Nodes by their keys. Those at corners of triangles, most of them in fine meshes, need no hashing.
typedef struct node_table {
    uint32_t *at_corner;   ///< [3 face_count] by welded corner; RSV_NONE = none yet
    rsv_index_map between; ///< of all other keys
} node_table;

static rsv_status create_table(const rsv_elements *e, node_table *nodes)
{
    size_t finer = 0;
    for (size_t c = 0; c < e->cell_count; c++)
        finer += e->cell[c].level > 0;
    nodes->at_corner = rsv_alloc(e->context, 3 * e->face_count, sizeof *nodes->at_corner);
    if (!nodes->at_corner) return RSV_ERROR_MEMORY;
    memset(nodes->at_corner, 0xff, 3 * e->face_count * sizeof *nodes->at_corner);
    return rsv_index_map_create(e->context, finer * 2 / 3 + 16, &nodes->between);
}

static void destroy_table(rsv_context *context, node_table *nodes)
{
    rsv_free(context, nodes->at_corner);
    rsv_index_map_destroy(&nodes->between);
}

/// The node at a lattice point, a fresh one if there is none yet. @return UINT32_MAX if memory is short
static uint32_t node_at(rsv_elements *e, node_table *nodes, uint32_t face, lattice_point p)
{
    uint64_t key = node_key(e, face, p);
    uint32_t fresh = (uint32_t)e->node_count;
    if (key >= BETWEEN_CORNERS) {
        uint32_t node = rsv_index_map_insert(&nodes->between, key, fresh);
        e->node_count += node == fresh;
        return node;
    }
    if (nodes->at_corner[key] == RSV_NONE) nodes->at_corner[key] = (uint32_t)e->node_count++;
    return nodes->at_corner[key];
}

static rsv_status number_nodes(rsv_elements *e, node_table *nodes)
{
    e->node_count = 0;
    e->cell_node = rsv_alloc(e->context, e->cell_count, sizeof *e->cell_node);
    if (!e->cell_node) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++) {
        for (int k = 0; k < 3; k++) {
            e->cell_node[c][k] = node_at(e, nodes, e->cell[c].face, corner_point(&e->cell[c], k));
            if (e->cell_node[c][k] == UINT32_MAX) return RSV_ERROR_MEMORY;
        }
    }
    return RSV_OK;
}

typedef struct hanging_finder {
    rsv_elements *e;
    const rsv_index_map *nodes; ///< between corners
    uint8_t *face_finest;       ///< [face_count] level of the smallest cells
    uint8_t *edge_finest;       ///< [3 face_count] by welded edge, of the faces that share it
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
    e->hanging[e->hanging_count++] =
        (rsv_hanging){ node, { a, b, a, a }, { 1 - weight, weight, 0, 0 } };
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

/// Notes how small cells are in each face and beside each edge. @return the level of the smallest of all
static int find_finest(hanging_finder *f)
{
    const rsv_elements *e = f->e;
    int finest = 0;
    for (size_t c = 0; c < e->cell_count; c++) {
        uint8_t *in_face = &f->face_finest[e->cell[c].face], level = e->cell[c].level;
        *in_face = level > *in_face ? level : *in_face;
        finest = level > finest ? level : finest;
    }
    for (size_t face = 0; face < e->face_count; face++) {
        for (int k = 0; k < 3; k++) {
            uint8_t *beside = &f->edge_finest[e->face_edge[face][k]];
            *beside = f->face_finest[face] > *beside ? f->face_finest[face] : *beside;
        }
    }
    return finest;
}

/// Whether smaller cells may touch a cell: most are spared the search.
static bool may_meet_smaller(const hanging_finder *f, const rsv_cell *cell)
{
    if (f->face_finest[cell->face] > cell->level) return true;
    const uint32_t *edge = f->e->face_edge[cell->face];
    for (int k = 0; k < 3; k++)
        if (f->edge_finest[edge[k]] > cell->level) return true;
    return false;
}

/// Cells are visited from coarse to fine, so that parents come before their children.
static rsv_status find_hanging(hanging_finder *f)
{
    rsv_elements *e = f->e;
    e->node_hanging = rsv_alloc(e->context, e->node_count, sizeof *e->node_hanging);
    f->unbalanced = rsv_alloc(e->context, e->cell_count, 1);
    f->face_finest = rsv_alloc(e->context, e->face_count, 1);
    f->edge_finest = rsv_alloc(e->context, 3 * e->face_count, 1);
    if (!e->node_hanging || !f->unbalanced || !f->face_finest || !f->edge_finest)
        return RSV_ERROR_MEMORY;
    memset(e->node_hanging, 0xff, e->node_count * sizeof *e->node_hanging);
    int finest = find_finest(f);
    for (int level = 0; level < finest; level++) {
        for (size_t c = 0; c < e->cell_count; c++) {
            if (e->cell[c].level != level || !may_meet_smaller(f, &e->cell[c])) continue;
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
            e->node_area[node] += rsv_cell_area(e, (uint32_t)c) / 3;
            e->node_face[node] = e->cell[c].face;
        }
    }
    for (size_t n = 0; n < e->node_count; n++) // undo the shift by one
        e->support_begin[n] = e->support_begin[n + 1];
    e->support_begin[e->node_count] = (uint32_t)(3 * e->cell_count);
    for (size_t h = e->hanging_count; h-- > 0;) {
        const rsv_hanging *hanging = &e->hanging[h];
        float area = e->node_area[hanging->node];
        for (int p = 0; p < RSV_PARENTS; p++)
            e->node_area[hanging->parent[p]] += hanging->weight[p] * area;
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

rsv_status rsv_elements_number_nodes(rsv_elements *e, uint8_t **unbalanced, bool *any_unbalanced)
{
    rsv_status status;
    node_table nodes = { 0 };
    hanging_finder finder = { .e = e, .nodes = &nodes.between };
    RSV_TRY(create_table(e, &nodes));
    RSV_TRY(number_nodes(e, &nodes));
    RSV_TRY(find_hanging(&finder));
    *any_unbalanced = finder.any_unbalanced;
    if (!finder.any_unbalanced) RSV_TRY(create_supports(e));
cleanup:
    *unbalanced = finder.unbalanced;
    rsv_free(e->context, finder.face_finest);
    rsv_free(e->context, finder.edge_finest);
    destroy_table(e->context, &nodes);
    return status;
}
