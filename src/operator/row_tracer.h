/// One row of G: gather rays from a node's support, each followed to the diffuse end of its specular path.
#ifndef RSV_ROW_TRACER_H
#define RSV_ROW_TRACER_H

#include "../update/row_record.h"
#include "directions.h"
#include "division.h"
#include "row_rays.h"
#include "transport.h"

#define RSV_ROW_BLOCK 64 ///< rows that a thread takes at a time

/// Data common to all rows; borrowed except for targets and directions.
typedef struct rsv_row_tracer {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_elements *elements;
    const uint16_t *valid_points; ///< [node_count] from rsv_find_buried
    uint32_t seed;
    rsv_ray_target *target; ///< [2 * triangle_count] front and back of each triangle
    rsv_directions directions;
} rsv_row_tracer;

/// Computes targets and directions from the other fields.
/// @param rays per row
rsv_status rsv_row_tracer_begin(rsv_row_tracer *tracer, uint32_t rays);
void rsv_row_tracer_end(rsv_row_tracer *tracer);

rsv_status rsv_row_scratch_create(rsv_context *context, uint32_t rays, rsv_row_scratch *scratch);
void rsv_row_scratch_destroy(rsv_context *context, rsv_row_scratch *scratch);

/// @param node neither hanging nor buried @param scratch the calling thread's
void rsv_row_trace(const rsv_row_tracer *tracer, uint32_t node, rsv_row_scratch *scratch);

/// The same, but the rays whose ends still hold are not traced.
void rsv_row_retrace(const rsv_row_tracer *tracer, uint32_t node, const rsv_kept_row *kept,
    rsv_row_scratch *scratch);

/// Parts of rsv_row_trace, for callers that trace the rays of many rows together: the origins of rays, and the
/// processing of their ends. @param receiver of the row
void rsv_row_receive(const rsv_row_tracer *tracer, uint32_t node, rsv_row_receiver *receiver);
void rsv_row_finish(const rsv_row_tracer *tracer, const rsv_row_receiver *receiver,
    const rsv_row_ends *ends, rsv_row_scratch *scratch);

/// The curve through all nodes, with the costs of their rows, measured on a few. @param tracer its directions are not
/// used
rsv_status rsv_row_costs(const rsv_row_tracer *tracer, rsv_division **division);

#endif
