/// Cells of a light table, and how a place is found in them: plain C, also for device code.
#ifndef RSV_LIGHT_CELLS_H
#define RSV_LIGHT_CELLS_H

#include "../core/triangle_grid.h"

#include <string.h>

/// Radiance at the corners; the fourth component of the first one is the index of the first of four children, as an
/// integer, or 0 if the cell is not split.
typedef struct rsv_light_cell {
    float corner[3][4];
} rsv_light_cell;

typedef enum rsv_shown_kind {
    RSV_SHOWN_STORED, ///< the table has all of it
    RSV_SHOWN_CHAIN,  ///< mirror, glass, texture, ...: to be followed by a specular path
    RSV_SHOWN_SKY,
    RSV_SHOWN_GLOSSY ///< the table has the irradiance, rsv_glossy_material what becomes of it
} rsv_shown_kind;

/// One side of a triangle.
typedef struct rsv_shown_side {
    uint32_t cell;  ///< first of its grid; RSV_SHOWN_CHAIN: 1 + material
    uint16_t level; ///< of the grid: 2^level cells along an edge
    uint16_t kind;
} rsv_shown_side;

/// A place in the grid of a side: the cell of the grid, and weights of its corners.
typedef struct rsv_grid_place {
    uint32_t cell;
    float b0, b1, b2;
} rsv_grid_place;

RSV_INLINE rsv_grid_place rsv_grid_place_of(uint32_t cell, float b0, float b1, float b2)
{
    rsv_grid_place place = { cell, b0, b1, b2 };
    return place;
}

/// As rsv_elements_locate, without the descent.
RSV_INLINE rsv_grid_place rsv_place_in_grid(rsv_shown_side side, float u, float v)
{
    rsv_triangle_place at = rsv_triangle_grid_find(1 << side.level, u, v);
    rsv_grid_place place;
    place.cell = side.cell + at.index;
    // points outside the cell due to rounding are moved to its border
    place.b0 = f_min(f_max(at.b0, 0), 1);
    place.b1 = f_min(f_max(at.b1, 0), 1 - place.b0);
    place.b2 = 1 - place.b0 - place.b1;
    return place;
}

RSV_INLINE uint32_t rsv_light_cell_child(const rsv_light_cell *cell)
{
    uint32_t child;
    memcpy(&child, &cell->corner[0][3], sizeof child);
    return child;
}

/// Moves on to the part of a split cell that holds the place, until it is whole.
RSV_INLINE rsv_grid_place rsv_descend(const rsv_light_cell *cells, rsv_grid_place at)
{
    for (uint32_t child = rsv_light_cell_child(cells + at.cell); child;
         child = rsv_light_cell_child(cells + at.cell)) {
        float b0 = 2 * at.b0, b1 = 2 * at.b1, b2 = 2 * at.b2;
        if (b0 >= 1)
            at = rsv_grid_place_of(child, b0 - 1, b1, b2);
        else if (b1 >= 1)
            at = rsv_grid_place_of(child + 1, b0, b1 - 1, b2);
        else if (b2 >= 1)
            at = rsv_grid_place_of(child + 2, b0, b1, b2 - 1);
        else
            at = rsv_grid_place_of(child + 3, 1 - b0, 1 - b1, 1 - b2);
    }
    return at;
}

/// Radiance at a place.
RSV_INLINE rsv_rgb rsv_radiance_at(const rsv_light_cell *cells, rsv_grid_place place)
{
    rsv_grid_place at = rsv_descend(cells, place);
    const rsv_light_cell *cell = &cells[at.cell];
    const float *a = cell->corner[0], *b = cell->corner[1], *c = cell->corner[2];
    return rgb(a[0] * at.b0 + b[0] * at.b1 + c[0] * at.b2,
        a[1] * at.b0 + b[1] * at.b1 + c[1] * at.b2, a[2] * at.b0 + b[2] * at.b1 + c[2] * at.b2);
}

#endif
