/// Builds operator and light of a scene together: pilots choose the elements, rows are traced on them, E0 is computed,
/// and the system is solved.
#ifndef RSV_BUILDER_H
#define RSV_BUILDER_H

#include "../elements/spacing.h"
#include "../update/update.h"
#include "light_internal.h"

/// State before there is an operator.
typedef struct rsv_builder {
    rsv_context *context;
    rsv_solve_desc desc;  ///< with fewer rays than requested if a budget requires it
    uint32_t wanted_rays; ///< requested rays
    float wanted_metres;  ///< requested spacing
    size_t bytes_left;    ///< of the memory budget, for elements, rows and levels
    rsv_world *world;
    rsv_transport_scene scene; ///< of that, with `update`
    rsv_update update;         ///< results from before an edit, and the store of rows
    rsv_light_sources *sources;
    rsv_spacing spacing;     ///< of the coarse elements
    rsv_elements *elements;  ///< coarse: the future unknowns
    uint16_t *valid_points;  ///< [node_count] receiver points that are not buried, bit by bit
    rsv_solve_report report; ///< of the work so far
    rsv_update_report kept;  ///< the same for reuse
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

/// Builds and solves. @param store for results that the next solve can reuse; NULL = none
/// @param earlier results of a solve of an earlier version of the scene; NULL = none
rsv_status rsv_light_build(const rsv_scene *scene, const rsv_solve_desc *desc, rsv_store *store,
    rsv_store *earlier, rsv_light **solution);

#endif
