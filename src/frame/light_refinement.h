/// The common refinement of a solution's fields, which are on several subdivisions of the same faces: the coarse
/// elements, the direct, the caustic and the diffused level. Within a cell of their common refinement, all of them are
/// linear.
#ifndef RSV_LIGHT_REFINEMENT_H
#define RSV_LIGHT_REFINEMENT_H

#include "../solve/light.h"
#include "light_cells.h"

/// A field on elements of its own.
typedef struct rsv_stored_field {
    const rsv_elements *elements;
    const rsv_rgb *value; ///< [node_count]
    float sign;           ///< 1, or -1 = taken away
} rsv_stored_field;

/// Number of fields that add up to the displayed light.
#define RSV_MAX_FIELDS 4
typedef struct rsv_field_sum {
    rsv_stored_field part[RSV_MAX_FIELDS];
    int count;
} rsv_field_sum;

/// Subdivisions that may differ.
#define RSV_REFINED_LEVELS 4

/// Traverses the cells of one face after the other. They are stored in a table: first a regular grid, in the order of
/// rsv_place_in_grid, then the children of its cells, four by four.
typedef struct rsv_face_walk {
    const rsv_elements *level[RSV_REFINED_LEVELS]; ///< the coarse one first; NULL = not there
    const rsv_light_view *solution;
    const rsv_field_sum *sum;
    const rsv_field_sum *detail; ///< of which only a share survives diffusion; NULL = none
    rsv_rgb scale, offset;       ///< radiance = offset + scale * irradiance
    rsv_light_cell *cell;        ///< the table, or NULL to count cells only
    float least;                 ///< radiance below which changes count as if it were so much
    float change;                ///< of the cells filled, relative, at most
    uint32_t grid_level;         ///< of the face: 2^level cells along an edge
    uint32_t grid;               ///< first cell of the face
    uint32_t next;               ///< first cell that is not in use yet
} rsv_face_walk;

/// The largest difference of a channel over the largest value, 0..1. @param least value
float rsv_light_change(const float before[3], const float after[3], float least);

rsv_face_walk rsv_face_walk_begin(const rsv_light_view *solution);

/// The level of a face's grid: the coarsest one that has a whole cell. A coarser one would take more cells, and one
/// more step to every place.
uint32_t rsv_face_grid_level(const rsv_face_walk *walk, uint32_t face);

/// Fills or counts the cells of a face.
/// @param grid_level at least that of the coarse elements @param first cell of the grid
/// @return the cell after its last one
uint32_t rsv_face_walk_cells(
    rsv_face_walk *walk, uint32_t face, uint32_t grid_level, uint32_t first);

#endif
