/// The unknowns' elements, ready to receive: walls kept apart, fine meshes clustered, buried points known, buried
/// corners bridged.
#ifndef RSV_COARSE_ELEMENTS_H
#define RSV_COARSE_ELEMENTS_H

#include "builder.h"
#include "goal.h"

/// @param coarsening how much larger than the builder's spacing
rsv_status rsv_coarse_elements_create(rsv_builder *builder, float coarsening);

/// Elements of the sizes that a goal wishes; those that other geometry cuts are split in the end.
rsv_status rsv_coarse_elements_create_for_goal(rsv_builder *builder, const rsv_goal *goal);

/// @param split [cell_count] cells to split
rsv_status rsv_coarse_elements_split(rsv_builder *builder, const uint8_t *split);

/// The same, but keeps the elements if the result does not fit.
/// @param kept out: whether they were split
rsv_status rsv_coarse_elements_try(
    rsv_builder *builder, const uint8_t *split, bool (*fits)(const rsv_builder *), bool *kept);

#endif
