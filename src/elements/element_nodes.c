/// Numbers the corners of cells and finds those that hang. All threads work on it: the number of a node follows from
/// the place, 4 * cell + corner, at which it is met first.
#include "elements_constants.h"
#include "elements_internal.h"

#include "../core/parallel.h"
#include "node_table.h"

#include <string.h>

static uint32_t read(const rsv_node_table *nodes, uint32_t entry)
{
    return atomic_load_explicit(rsv_node_table_at(nodes, entry), memory_order_relaxed);
}

/// Of some consecutive cells: which corners are the first places of their nodes, as bits of `first`. @return how many
static uint32_t mark_first(
    const rsv_elements *e, const rsv_node_table *nodes, size_t begin, size_t end, uint8_t *first)
{
    uint32_t count = 0;
    for (size_t c = begin; c < end; c++) {
        first[c] = 0;
        for (uint32_t k = 0; k < 3; k++) {
            bool is_first = read(nodes, e->cell_node[c][k]) == 4 * (uint32_t)c + k;
            first[c] |= (uint8_t)(is_first << k);
            count += is_first;
        }
    }
    return count;
}

/// Numbers the nodes that are met first in some consecutive cells. The table keeps numbers from then on.
static void number_first(const rsv_elements *e, const rsv_node_table *nodes, size_t begin,
    size_t end, const uint8_t *first, uint32_t number)
{
    for (size_t c = begin; c < end; c++)
        for (uint32_t k = 0; k < 3; k++)
            if (first[c] >> k & 1)
                atomic_store_explicit(
                    rsv_node_table_at(nodes, e->cell_node[c][k]), number++, memory_order_relaxed);
}

static size_t end_of_block(const rsv_elements *e, size_t block)
{
    size_t end = (block + 1) * CELLS_AT_A_TIME;
    return end < e->cell_count ? end : e->cell_count;
}

/// Nodes while they are found and numbered.
typedef struct numbering {
    rsv_elements *e;
    rsv_node_table *nodes;
    uint32_t *begin; ///< [blocks + 1] first number of a block of cells
    uint8_t *first;  ///< [cell_count] bit k: the cell is the first at its corner k
} numbering;

static void note_corners(void *user, rsv_span span)
{
    const numbering *n = user;
    const rsv_elements *e = n->e;
    for (size_t c = span.begin; c < span.end; c++)
        for (int k = 0; k < 3; k++)
            e->cell_node[c][k] = rsv_node_table_note(n->nodes, e->cell[c].face,
                rsv_lattice_corner(&e->cell[c], k), 4 * (uint32_t)c + (uint32_t)k);
}

static void mark_blocks(void *user, rsv_span span)
{
    const numbering *n = user;
    for (size_t b = span.begin; b < span.end; b++)
        n->begin[b + 1] =
            mark_first(n->e, n->nodes, b * CELLS_AT_A_TIME, end_of_block(n->e, b), n->first);
}

static void number_blocks(void *user, rsv_span span)
{
    const numbering *n = user;
    for (size_t b = span.begin; b < span.end; b++)
        number_first(
            n->e, n->nodes, b * CELLS_AT_A_TIME, end_of_block(n->e, b), n->first, n->begin[b]);
}

static void read_numbers(void *user, rsv_span span)
{
    const numbering *n = user;
    for (size_t c = span.begin; c < span.end; c++)
        for (int k = 0; k < 3; k++)
            n->e->cell_node[c][k] = read(n->nodes, n->e->cell_node[c][k]);
}

/// Notes all nodes in the table, whose entries cell_node has until they are numbered.
static rsv_status note_nodes(rsv_elements *e, rsv_node_table *nodes)
{
    e->cell_node = rsv_reserve(e->context, e->cell_count, sizeof *e->cell_node);
    if (!e->cell_node) return RSV_ERROR_MEMORY;
    rsv_parallel_for(
        e->context, e->cell_count, 0, note_corners, &(numbering){ e, nodes, NULL, NULL });
    return RSV_OK;
}

static rsv_status number_nodes(rsv_elements *e, rsv_node_table *nodes)
{
    rsv_status status = RSV_OK;
    size_t blocks = (e->cell_count + CELLS_AT_A_TIME - 1) / CELLS_AT_A_TIME;
    uint32_t *begin = rsv_alloc(e->context, blocks + 1, sizeof *begin);
    uint8_t *first = rsv_reserve(e->context, e->cell_count, 1);
    RSV_TRY(begin && first ? RSV_OK : RSV_ERROR_MEMORY);
    numbering n = { e, nodes, begin, first };
    rsv_parallel_for(e->context, blocks, 0, mark_blocks, &n);
    for (size_t b = 0; b < blocks; b++)
        begin[b + 1] += begin[b];
    e->node_count = begin[blocks];
    rsv_parallel_for(e->context, blocks, 0, number_blocks, &n);
    rsv_parallel_for(e->context, e->cell_count, 0, read_numbers, &n);
cleanup:
    rsv_free(e->context, begin);
    rsv_free(e->context, first);
    return status;
}

/// Nodes that some consecutive cells find on their edges.
typedef struct found_list {
    struct found {
        uint32_t node, a, b; ///< entries of the table; a, b: ends of the edge
        float weight;        ///< of b
        int level;           ///< of the cell
    } * found;
    size_t count, capacity;
    rsv_status status;
} found_list;

typedef struct hanging_finder {
    rsv_elements *e;
    const rsv_node_table *nodes;
    uint8_t *unbalanced; ///< [cell_count] edge halved more than once
    found_list *list;    ///< [list_count] of CELLS_AT_A_TIME cells each
    size_t list_count;
} hanging_finder;

/// Part of an edge of a cell: from place `t[0]` to `t[1]` of the way from its node `a` to `b`.
typedef struct edge_part {
    uint32_t cell, a, b;
    rsv_lattice_point p[2];
    float t[2];
} edge_part;

/// Nodes strictly within a part of an edge, by bisection.
static rsv_status find_between(
    const hanging_finder *f, found_list *list, const edge_part *part, int depth)
{
    const rsv_lattice_point p = part->p[0], q = part->p[1],
                            m = { (p.i + q.i) / 2, (p.j + q.j) / 2 };
    const rsv_cell *cell = &f->e->cell[part->cell];
    if ((p.i == m.i && p.j == m.j) || (q.i == m.i && q.j == m.j)) return RSV_OK;
    uint32_t entry = rsv_node_table_find(f->nodes, cell->face, m);
    if (entry == RSV_NONE) return RSV_OK;
    if (depth > 0) f->unbalanced[part->cell] = 1;
    float t = 0.5f * (part->t[0] + part->t[1]);
    rsv_status status = rsv_grow(f->e->context, (void **)&list->found, &list->capacity,
        list->count + 1, sizeof *list->found);
    if (status != RSV_OK) return status;
    list->found[list->count++] = (struct found){ entry, part->a, part->b, t, cell->level };
    edge_part first = *part, second = *part;
    first.p[1] = second.p[0] = m;
    first.t[1] = second.t[0] = t;
    status = find_between(f, list, &first, depth + 1);
    return status == RSV_OK ? find_between(f, list, &second, depth + 1) : status;
}

/// Whether smaller cells may touch a cell: most are spared the search.
static bool may_meet_smaller(const hanging_finder *f, const rsv_cell *cell)
{
    if (f->nodes->face_finest[cell->face] > cell->level) return true;
    const uint32_t *edge = f->e->face_edge[cell->face];
    for (int k = 0; k < 3; k++)
        if (f->nodes->edge_finest[edge[k]] > cell->level) return true;
    return false;
}

static rsv_status find_in_cell(const hanging_finder *f, found_list *list, uint32_t c)
{
    const rsv_cell *cell = &f->e->cell[c];
    const uint32_t *node = f->e->cell_node[c];
    rsv_status status = RSV_OK;
    if (!may_meet_smaller(f, cell)) return RSV_OK;
    for (int k = 0; k < 3 && status == RSV_OK; k++) {
        int l = (k + 1) % 3;
        const edge_part edge = { c, node[k], node[l],
            { rsv_lattice_corner(cell, k), rsv_lattice_corner(cell, l) }, { 0, 1 } };
        status = find_between(f, list, &edge, 0);
    }
    return status;
}

static rsv_status prepare_finder(hanging_finder *f)
{
    rsv_elements *e = f->e;
    f->list_count = (e->cell_count + CELLS_AT_A_TIME - 1) / CELLS_AT_A_TIME;
    f->list = rsv_alloc(e->context, f->list_count, sizeof *f->list);
    f->unbalanced = rsv_alloc(e->context, e->cell_count, 1);
    if (!f->list || !f->unbalanced) return RSV_ERROR_MEMORY;
    return RSV_OK;
}

static void search_blocks(void *user, rsv_span span)
{
    hanging_finder *f = user;
    for (size_t b = span.begin; b < span.end; b++) {
        found_list *list = &f->list[b];
        for (size_t c = b * CELLS_AT_A_TIME; c < end_of_block(f->e, b) && !list->status; c++)
            list->status = find_in_cell(f, list, (uint32_t)c);
    }
}

static rsv_status search_cells(hanging_finder *f)
{
    rsv_parallel_for(f->e->context, f->list_count, 1, search_blocks, f);
    for (size_t b = 0; b < f->list_count; b++)
        if (f->list[b].status) return f->list[b].status;
    return RSV_OK;
}

static void hang_node(rsv_elements *e, uint32_t node, uint32_t a, uint32_t b, float weight)
{
    if (e->node_hanging[node] != RSV_NONE) return; // an edge shared by more than two faces
    e->node_hanging[node] = (uint32_t)e->hanging_count;
    e->hanging[e->hanging_count++] =
        (rsv_hanging){ node, { a, b, a, a }, { 1 - weight, weight, 0, 0 } };
}

/// Once nodes are numbered. Edges count from coarse to fine, so that parents come before their children.
static rsv_status hang_nodes(const hanging_finder *f)
{
    rsv_elements *e = f->e;
    size_t most = 0;
    for (size_t b = 0; b < f->list_count; b++)
        most += f->list[b].count;
    e->hanging = rsv_reserve(e->context, most, sizeof *e->hanging);
    e->node_hanging = rsv_reserve(e->context, e->node_count, sizeof *e->node_hanging);
    if (!e->hanging || !e->node_hanging) return RSV_ERROR_MEMORY;
    memset(e->node_hanging, 0xff, e->node_count * sizeof *e->node_hanging);
    for (int level = 0; level < RSV_MAX_LEVEL; level++) {
        for (size_t b = 0; b < f->list_count; b++) {
            for (size_t k = 0; k < f->list[b].count; k++) {
                const struct found *n = &f->list[b].found[k];
                if (n->level == level)
                    hang_node(e, read(f->nodes, n->node), read(f->nodes, n->a),
                        read(f->nodes, n->b), n->weight);
            }
        }
    }
    return RSV_OK;
}

static void destroy_finder(hanging_finder *f)
{
    rsv_context *context = f->e->context;
    for (size_t b = 0; f->list && b < f->list_count; b++)
        rsv_free(context, f->list[b].found);
    rsv_free(context, f->list);
}

rsv_status rsv_elements_number_nodes(rsv_elements *e, uint8_t **unbalanced, bool *any_unbalanced)
{
    rsv_status status;
    rsv_node_table nodes = { 0 };
    hanging_finder finder = { .e = e, .nodes = &nodes };
    RSV_TRY(rsv_elements_are_countable(e));
    RSV_TRY(rsv_node_table_create(e, &nodes));
    RSV_TRY(note_nodes(e, &nodes));
    RSV_TRY(prepare_finder(&finder));
    RSV_TRY(search_cells(&finder));
    *any_unbalanced = memchr(finder.unbalanced, 1, e->cell_count) != NULL;
    if (*any_unbalanced) goto cleanup;
    RSV_TRY(number_nodes(e, &nodes));
    RSV_TRY(hang_nodes(&finder));
    RSV_TRY(rsv_elements_create_supports(e));
cleanup:
    *unbalanced = finder.unbalanced;
    destroy_finder(&finder);
    rsv_node_table_destroy(&nodes);
    return status;
}
