/// Cells that a wall cuts with open corners on both of its sides: each side of the wall takes its light from its own
/// corners, up to the line on which the wall stands.
#ifndef RSV_CUT_CELLS_H
#define RSV_CUT_CELLS_H

#include "../specular/specular_path.h"
#include "elements.h"

/// Finds the lines (`cell_cut`, `cut_side`) anew. Requires the openness of cells, and nodes that are separated by walls.
rsv_status rsv_elements_find_cuts(
    const rsv_transport_scene *scene, rsv_elements *elements, uint64_t *rays);

/// The share of a cell's area that each of its corners stands for: the integral of its weight; a third each without a
/// cut.
void rsv_cell_shares(const rsv_elements *elements, uint32_t cell, float share[3]);

#endif
