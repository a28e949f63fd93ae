/// The unknowns' elements, ready to receive: walls kept apart, fine meshes clustered, buried points known, buried
/// corners bridged.
#ifndef RSV_COARSE_ELEMENTS_H
#define RSV_COARSE_ELEMENTS_H

#include "solution.h"

/// @param coarsening elements start larger than the solution's spacing by this factor, to be split where that is too large
rsv_status rsv_coarse_elements_create(rsv_solution *solution, float coarsening);

/// @param split [cell_count] cells to split
rsv_status rsv_coarse_elements_split(rsv_solution *solution, const uint8_t *split);

#endif
