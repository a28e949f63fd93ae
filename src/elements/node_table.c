#include "node_table.h"
#include "../core/parallel.h"

#define LATTICE (1u << RSV_MAX_LEVEL) ///< side of the finest barycentric lattice

/// Dense tables of points are used up to this many points per cell.
#define MOST_POINTS_PER_CELL 8
/// Entries that lie side by side at most: numbers of entries have 32 bits, and the rest must find room.
#define MOST_EVEN (RSV_NONE / 8)

/// Where on the surfaces a point lies.
typedef struct site {
    bool on_lattice; ///< the smallest cells around have corners there
    uint32_t begin;  ///< as in the table; RSV_NONE = hashed
    uint32_t index;
    uint64_t key; ///< where hashed
} site;

/// @param t from corner `from` on
static site site_on_edge(
    const rsv_node_table *n, uint32_t face, int k, int from, int to, uint32_t t)
{
    const rsv_elements *e = n->elements;
    uint32_t edge = e->face_edge[face][k], shift = RSV_MAX_LEVEL - n->edge_finest[edge];
    if (e->face_corner[face][from] >= e->face_corner[face][to]) t = LATTICE - t;
    return (site){ .on_lattice = (t & ((1u << shift) - 1)) == 0,
        .begin = n->edge_begin[edge],
        .index = (t >> shift) - 1,
        .key = 1ull << 62 | (uint64_t)edge << 15 | t };
}

static site site_inside(const rsv_node_table *n, uint32_t face, rsv_lattice_point p)
{
    uint32_t shift = RSV_MAX_LEVEL - n->face_finest[face], side = 1u << n->face_finest[face];
    uint32_t row = (p.j >> shift) - 1,
             at = (p.i >> shift) - 1; // a row is one shorter than that before
    return (site){ .on_lattice = ((p.i | p.j) & ((1u << shift) - 1)) == 0,
        .begin = n->face_begin[face],
        .index = row * (2 * side - 3 - row) / 2 + at,
        .key = 2ull << 62 | (uint64_t)face << 28 | (uint64_t)p.i << 14 | p.j };
}

static site site_at_corner(const rsv_node_table *n, uint32_t face, int k)
{
    return (site){ .on_lattice = true, .index = n->elements->face_corner[face][k] };
}

static site site_of(const rsv_node_table *n, uint32_t face, rsv_lattice_point p)
{
    if (p.i == 0 && p.j == 0) return site_at_corner(n, face, 0);
    if (p.i == LATTICE) return site_at_corner(n, face, 1);
    if (p.j == LATTICE) return site_at_corner(n, face, 2);
    if (p.j == 0) return site_on_edge(n, face, 0, 0, 1, p.i);
    if (p.i == 0) return site_on_edge(n, face, 1, 0, 2, p.j);
    if (p.i + p.j == LATTICE) return site_on_edge(n, face, 2, 1, 2, p.j);
    return site_inside(n, face, p);
}

uint32_t rsv_node_table_note(
    rsv_node_table *n, uint32_t face, rsv_lattice_point point, uint32_t place)
{
    site s = site_of(n, face, point);
    if (s.begin == RSV_NONE)
        return (uint32_t)n->even_count + rsv_first_map_note(&n->uneven, s.key, place);
    rsv_lower(&n->even[s.begin + s.index], place);
    return s.begin + s.index;
}

uint32_t rsv_node_table_find(const rsv_node_table *n, uint32_t face, rsv_lattice_point point)
{
    site s = site_of(n, face, point);
    if (!s.on_lattice) return RSV_NONE;
    if (s.begin == RSV_NONE) {
        uint32_t slot = rsv_first_map_find(&n->uneven, s.key);
        return slot == UINT32_MAX ? RSV_NONE : (uint32_t)n->even_count + slot;
    }
    uint32_t entry = s.begin + s.index;
    bool is_node = atomic_load_explicit(&n->even[entry], memory_order_relaxed) != RSV_NONE;
    return is_node ? entry : RSV_NONE;
}

static uint32_t higher(uint32_t a, uint32_t b) { return a > b ? a : b; }

/// Records how small cells are in each face and at each edge.
/// @param face_cells, edge_cells out: number of cells; at an edge, in the face with the most
static void measure(rsv_node_table *n, uint32_t *face_cells, uint32_t *edge_cells)
{
    const rsv_elements *e = n->elements;
    for (size_t c = 0; c < e->cell_count; c++) {
        const rsv_cell *cell = &e->cell[c];
        if (cell->level > n->face_finest[cell->face]) n->face_finest[cell->face] = cell->level;
        face_cells[cell->face]++;
    }
    for (size_t face = 0; face < e->face_count; face++) {
        for (int k = 0; k < 3; k++) {
            uint32_t edge = e->face_edge[face][k];
            n->edge_finest[edge] = (uint8_t)higher(n->edge_finest[edge], n->face_finest[face]);
            edge_cells[edge] = higher(edge_cells[edge], face_cells[face]);
        }
    }
}

/// Reserves places for points; RSV_NONE if they are too sparse.
static uint32_t place_points(rsv_node_table *n, size_t points, size_t cells)
{
    size_t begin = n->even_count;
    if (points > MOST_POINTS_PER_CELL * cells || begin + points > MOST_EVEN) return RSV_NONE;
    n->even_count += points;
    return (uint32_t)begin;
}

/// Decides which points are stored densely. @return maximum number of hashed points
static size_t place_all(rsv_node_table *n, const uint32_t *face_cells, const uint32_t *edge_cells)
{
    const rsv_elements *e = n->elements;
    size_t hashed = 0;
    n->even_count = 3 * e->face_count;
    for (size_t edge = 0; edge < 3 * e->face_count; edge++)
        n->edge_begin[edge] = place_points(n, (1u << n->edge_finest[edge]) - 1, edge_cells[edge]);
    for (size_t face = 0; face < e->face_count; face++) {
        size_t side = (size_t)1 << n->face_finest[face];
        n->face_begin[face] = place_points(n, (side - 1) * (side - 2) / 2, face_cells[face]);
        const uint32_t *edge = e->face_edge[face];
        // each split of a cell adds three cells, and no more nodes than that
        if (n->face_begin[face] == RSV_NONE || n->edge_begin[edge[0]] == RSV_NONE ||
            n->edge_begin[edge[1]] == RSV_NONE || n->edge_begin[edge[2]] == RSV_NONE)
            hashed += face_cells[face];
    }
    return hashed;
}

static void clear_even(void *user, rsv_span span)
{
    const rsv_node_table *n = user;
    for (size_t k = span.begin; k < span.end; k++)
        atomic_init(&n->even[k], RSV_NONE);
}

rsv_status rsv_node_table_create(const rsv_elements *e, rsv_node_table *n)
{
    rsv_status status;
    rsv_context *context = e->context;
    uint32_t *face_cells = rsv_alloc(context, e->face_count, sizeof *face_cells);
    uint32_t *edge_cells = rsv_alloc(context, 3 * e->face_count, sizeof *edge_cells);
    *n = (rsv_node_table){ .elements = e };
    n->face_finest = rsv_alloc(context, e->face_count, 1);
    n->edge_finest = rsv_alloc(context, 3 * e->face_count, 1);
    n->face_begin = rsv_reserve(context, e->face_count, sizeof *n->face_begin);
    n->edge_begin = rsv_reserve(context, 3 * e->face_count, sizeof *n->edge_begin);
    bool complete = face_cells && edge_cells && n->face_finest && n->edge_finest && n->face_begin &&
                    n->edge_begin;
    RSV_TRY(complete ? RSV_OK : RSV_ERROR_MEMORY);
    measure(n, face_cells, edge_cells);
    size_t hashed = place_all(n, face_cells, edge_cells);
    n->even = rsv_reserve(context, n->even_count, sizeof *n->even);
    RSV_TRY(n->even ? RSV_OK : RSV_ERROR_MEMORY);
    rsv_parallel_for(context, n->even_count, 0, clear_even, n);
    status = rsv_first_map_create(context, hashed, &n->uneven);
cleanup:
    rsv_free(context, face_cells);
    rsv_free(context, edge_cells);
    return status;
}

void rsv_node_table_destroy(rsv_node_table *n)
{
    if (!n->elements) return;
    rsv_context *context = n->elements->context;
    rsv_free(context, n->face_finest);
    rsv_free(context, n->edge_finest);
    rsv_free(context, n->face_begin);
    rsv_free(context, n->edge_begin);
    rsv_free(context, (void *)n->even);
    rsv_first_map_destroy(&n->uneven);
    *n = (rsv_node_table){ 0 };
}
