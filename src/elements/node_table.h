/// Nodes by position: at a corner of a face, on an edge, or inside. Faces that share a welded corner or edge share its
/// nodes. All threads fill the table in parallel.
#ifndef RSV_NODE_TABLE_H
#define RSV_NODE_TABLE_H

#include "../core/first_map.h"
#include "elements.h"

/// Position of a node on a face's finest lattice.
typedef struct rsv_lattice_point {
    uint32_t i, j;
} rsv_lattice_point;

RSV_INLINE rsv_lattice_point rsv_lattice_corner(const rsv_cell *cell, int k)
{
    int shift = RSV_MAX_LEVEL - cell->level;
    uint32_t di = cell->flipped ? k != 1 : k == 1, dj = cell->flipped ? k != 2 : k == 2;
    return (rsv_lattice_point){ (cell->i + di) << shift, (cell->j + dj) << shift };
}

/// Edges and faces that are evenly divided keep all points of their finest cells side by side; the few points of others
/// are hashed.
typedef struct rsv_node_table {
    const rsv_elements *elements;
    uint8_t *face_finest;   ///< [face_count] level of the smallest cells
    uint8_t *edge_finest;   ///< [3 face_count] by welded edge: of the faces that share it
    uint32_t *face_begin;   ///< [face_count] first of the points inside; RSV_NONE = they are hashed
    uint32_t *edge_begin;   ///< [3 face_count] the same for edges
    _Atomic uint32_t *even; ///< [even_count] of welded corners, then of edges and faces
    size_t even_count;
    rsv_first_map uneven;
} rsv_node_table;

/// A table without nodes for the cells of `elements`, which is borrowed.
rsv_status rsv_node_table_create(const rsv_elements *elements, rsv_node_table *table);
void rsv_node_table_destroy(rsv_node_table *table);

/// Notes that a cell of `face` has a corner there. Any thread. @return the node's entry: the least `place` noted for it
uint32_t rsv_node_table_note(
    rsv_node_table *table, uint32_t face, rsv_lattice_point point, uint32_t place);

/// Of a point that is no corner of the face: the node's entry, or RSV_NONE. Any thread, after all have been noted.
uint32_t rsv_node_table_find(const rsv_node_table *table, uint32_t face, rsv_lattice_point point);

RSV_INLINE _Atomic uint32_t *rsv_node_table_at(const rsv_node_table *table, uint32_t entry)
{
    return entry < table->even_count ? &table->even[entry]
                                     : &table->uneven.slot[entry - table->even_count].first;
}

#endif
