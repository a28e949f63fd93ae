/// The regular grid on a triangle: `side` cells along each edge, numbered row by row, upright and flipped cells in
/// turns.
#ifndef RSV_TRIANGLE_GRID_H
#define RSV_TRIANGLE_GRID_H

#include "vec.h"

/// Number of a cell: row j starts after j (2 side - j) cells.
RSV_INLINE int32_t rsv_triangle_grid_index(int32_t side, int32_t i, int32_t j, int32_t flipped)
{
    return j * (2 * side - j) + 2 * i + flipped;
}

/// A place on the grid: the cell, and weights of its corners, which rounding may take a little out of 0 .. 1.
typedef struct rsv_triangle_place {
    uint32_t index;
    float b0, b1, b2;
} rsv_triangle_place;

/// @param u, v barycentric weights of the triangle's corners 1 and 2
RSV_INLINE rsv_triangle_place rsv_triangle_grid_find(int32_t side, float u, float v)
{
    float x = u * (float)side, y = v * (float)side;
    int32_t i = (int32_t)x, j = (int32_t)y;
    j = j < 0 ? 0 : j;
    j = j > side - 1 ? side - 1 : j;
    i = i < 0 ? 0 : i;
    i = i > side - 1 - j ? side - 1 - j : i;
    float fx = x - (float)i, fy = y - (float)j;
    int32_t flipped = (fx + fy > 1) & (i + j < side - 1);
    rsv_triangle_place place;
    place.index = (uint32_t)rsv_triangle_grid_index(side, i, j, flipped);
    place.b0 = flipped ? fx + fy - 1 : 1 - fx - fy;
    place.b1 = flipped ? 1 - fx : fx;
    place.b2 = flipped ? 1 - fy : fy;
    return place;
}

#endif
