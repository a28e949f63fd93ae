/// What plain surfaces show, ready to be looked up from (triangle, u, v).
///
/// The fields of a solution live on several subdivisions of the same triangles: the coarse elements, the direct and the
/// caustic level. Within a cell of their common refinement all of them are linear, so one table holds their sum, times
/// albedo / pi and with the emission added: radiance at the three corners of each cell.
#ifndef RSV_LIGHT_TABLE_H
#define RSV_LIGHT_TABLE_H

#include "../solve/solution.h"
#include "resolvent/frame.h"

/// Radiance at the corners; the fourth component of the first one is the index of the first of four children, as an
/// integer, or 0 if the cell is not split.
typedef struct rsv_light_cell {
    float corner[3][4];
} rsv_light_cell;

typedef enum rsv_shown_kind {
    RSV_SHOWN_STORED, ///< the table has all of it
    RSV_SHOWN_CHAIN,  ///< mirror, glass, texture, ...: to be followed
    RSV_SHOWN_SKY
} rsv_shown_kind;

/// One side of a triangle.
typedef struct rsv_shown_side {
    uint32_t cell;  ///< first of its grid
    uint16_t level; ///< of the grid: 2^level cells along an edge
    uint16_t kind;
} rsv_shown_side;

typedef struct rsv_light_table {
    rsv_context *context;
    const rsv_solution *solution;
    uint32_t layer;            ///< on show, RSV_NONE = all
    rsv_shown_side (*side)[2]; ///< [triangle_count + 1] front and back; the last: no triangle
    uint32_t triangle_count;
    uint32_t *face_cell; ///< [face_count + 1] first cell of each face
    rsv_light_cell *cell;
    size_t cell_count;
} rsv_light_table;

rsv_status rsv_light_table_create(const rsv_solution *solution, rsv_light_table *table);
void rsv_light_table_destroy(rsv_light_table *table);

/// Fills the cells from the solution's fields. @param layer as for rsv_frame_renderer_show
void rsv_light_table_bake(rsv_light_table *table, uint32_t layer);

/// Irradiance of the layer on show at a diffuse surface of any kind.
rsv_rgb rsv_shown_irradiance(const rsv_light_table *table, uint32_t face, float u, float v);

RSV_INLINE bool rsv_shows_emission(const rsv_light_table *table)
{
    return table->layer == RSV_NONE || table->layer == 0;
}

RSV_INLINE const rsv_shown_side *rsv_shown_side_of(
    const rsv_light_table *table, uint32_t triangle, bool back)
{
    return &table->side[triangle < table->triangle_count ? triangle : table->triangle_count][back];
}

/// A place in the grid of a side: the cell of the grid, and weights of its corners.
typedef struct rsv_grid_place {
    uint32_t cell;
    float b0, b1, b2;
} rsv_grid_place;

/// As rsv_elements_locate, without the descent.
RSV_INLINE rsv_grid_place rsv_place_in_grid(rsv_shown_side side, float u, float v)
{
    int cells = 1 << side.level;
    float x = u * (float)cells, y = v * (float)cells;
    int i = (int)x, j = (int)y;
    j = j < 0 ? 0 : j;
    j = j > cells - 1 ? cells - 1 : j;
    i = i < 0 ? 0 : i;
    i = i > cells - 1 - j ? cells - 1 - j : i;
    float fx = x - (float)i, fy = y - (float)j;
    int flipped = (fx + fy > 1) & (i + j < cells - 1);
    rsv_grid_place place;
    place.cell = side.cell + (uint32_t)(j * (2 * cells - j) + 2 * i + flipped);
    // what rounding puts outside the cell is moved to its border
    place.b0 = f_min(f_max(flipped ? fx + fy - 1 : 1 - fx - fy, 0), 1);
    place.b1 = f_min(f_max(flipped ? 1 - fx : fx, 0), 1 - place.b0);
    place.b2 = 1 - place.b0 - place.b1;
    return place;
}

typedef float rsv_float4 __attribute__((vector_size(16), aligned(16)));

RSV_INLINE uint32_t rsv_light_cell_child(const rsv_light_cell *cell)
{
    uint32_t child;
    __builtin_memcpy(&child, &cell->corner[0][3], sizeof child);
    return child;
}

/// Moves on to the part of a split cell that holds the place, until it is whole.
RSV_INLINE rsv_grid_place rsv_descend(const rsv_light_cell *cells, rsv_grid_place at)
{
    for (uint32_t child = rsv_light_cell_child(cells + at.cell); child;
         child = rsv_light_cell_child(cells + at.cell)) {
        float b0 = 2 * at.b0, b1 = 2 * at.b1, b2 = 2 * at.b2;
        if (b0 >= 1)
            at = (rsv_grid_place){ child, b0 - 1, b1, b2 };
        else if (b1 >= 1)
            at = (rsv_grid_place){ child + 1, b0, b1 - 1, b2 };
        else if (b2 >= 1)
            at = (rsv_grid_place){ child + 2, b0, b1, b2 - 1 };
        else
            at = (rsv_grid_place){ child + 3, 1 - b0, 1 - b1, 1 - b2 };
    }
    return at;
}

/// Radiance at a place; its fourth component means nothing.
RSV_INLINE rsv_float4 rsv_light_at(const rsv_light_cell *cells, rsv_grid_place place)
{
    rsv_grid_place at = rsv_descend(cells, place);
    const rsv_float4 *corner = (const rsv_float4 *)cells[at.cell].corner;
    return corner[0] * at.b0 + corner[1] * at.b1 + corner[2] * at.b2;
}

#endif
