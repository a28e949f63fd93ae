/// Building operator and light of a scene together: elements are chosen by what pilots see of the light, rows are traced
/// on them, E0 is found and the system solved.
#ifndef RSV_BUILDER_H
#define RSV_BUILDER_H

#include "../elements/spacing.h"
#include "../update/update.h"
#include "light_internal.h"

/// What there is before there is an operator.
typedef struct rsv_builder {
    rsv_context *context;
    rsv_solve_desc desc;  ///< with fewer rays than was asked for where a budget wants that
    uint32_t wanted_rays; ///< that were asked for
    float wanted_metres;  ///< of the spacing, likewise
    size_t bytes_left;    ///< of the memory budget, for elements, rows and levels
    rsv_world *world;
    rsv_transport_scene scene; ///< of that, with `update`
    rsv_update update;         ///< what is known from before an edit, and where rows are kept
    rsv_light_sources *sources;
    rsv_spacing spacing;     ///< of the coarse elements
    rsv_elements *elements;  ///< coarse: the unknowns to be
    uint16_t *valid_points;  ///< [node_count] receiver points that are not buried, bit by bit
    rsv_solve_report report; ///< of what was done so far
    rsv_update_report kept;  ///< likewise
} rsv_builder;

/// Nodes with a row of their own.
static inline size_t rsv_builder_rows(const rsv_builder *builder)
{
    return rsv_count_rows(builder->elements, builder->valid_points);
}

/// Rows on the elements in hand. @param rays of each row
/// @param valid_points [node_count] nodes without any get no row; NULL = the builder's
rsv_status rsv_builder_trace(
    rsv_builder *builder, const uint16_t *valid_points, uint32_t rays, rsv_operator **op);

/// Whether a scene can be solved by these settings: their bounds, and the goal.
rsv_status rsv_check_settings(const rsv_scene *scene, const rsv_solve_desc *desc);

/// Builds and solves. @param store where all is kept that the next solve may take over; NULL = nowhere
/// @param earlier what a solve of an earlier version of the scene kept; NULL = nothing
rsv_status rsv_light_build(const rsv_scene *scene, const rsv_solve_desc *desc, rsv_store *store,
    rsv_store *earlier, rsv_light **solution);

#endif
