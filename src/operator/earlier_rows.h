/// Rows that were traced before the scene was edited, and what of them still holds.
///
/// A ray that ended on a plain surface ends there still if the elements around its end are what they were, and if it does
/// not run through anything that is new. So rows of the same rays are taken over ray by ray. Rays that met specular
/// surfaces are traced anew; those that met black backs, too, unless it is known where what is gone was.
#ifndef RSV_EARLIER_ROWS_H
#define RSV_EARLIER_ROWS_H

#include "../elements/scene_change.h"
#include "row_catalogue.h"
#include "row_files.h"

typedef struct rsv_earlier_rows {
    rsv_context *context;
    rsv_row_files files;
    uint32_t *row_then; ///< [node_count] node then whose row has the same rays; RSV_NONE = none
    uint32_t *end_now;  ///< [node_count then] the same node now; RSV_NONE = there is none
    rsv_scene_change change;
    double seconds; ///< that tracing all rows took then
} rsv_earlier_rows;

/// Looks among the rows in a folder for those most like the rows to be traced. @param now of these
/// @param earlier out: NULL if there are none
rsv_status rsv_earlier_rows_open(const rsv_row_tracer *tracer, const rsv_row_catalogue *now,
    const char *folder, rsv_earlier_rows **earlier);
void rsv_earlier_rows_close(rsv_earlier_rows *earlier);

/// What the rays of a row found then. @param earlier NULL = nothing is known @return false if nothing is known
bool rsv_earlier_rows_find(const rsv_earlier_rows *earlier, uint32_t node, rsv_row_past *past);

#endif
