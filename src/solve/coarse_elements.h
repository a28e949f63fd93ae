/// The unknowns' elements, ready to receive: walls kept apart, fine meshes clustered, buried points known, buried
/// corners bridged.
#ifndef RSV_COARSE_ELEMENTS_H
#define RSV_COARSE_ELEMENTS_H

#include "goal.h"
#include "solution.h"

/// @param coarsening how much larger than the solution's spacing
rsv_status rsv_coarse_elements_create(rsv_solution *solution, float coarsening);

/// Elements of the sizes that a goal wishes; those that other geometry cuts are split in the end.
rsv_status rsv_coarse_elements_create_for_goal(rsv_solution *solution, const rsv_goal *goal);

/// @param split [cell_count] cells to split
rsv_status rsv_coarse_elements_split(rsv_solution *solution, const uint8_t *split);

#endif
