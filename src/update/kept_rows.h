/// Rows that were traced before the scene was edited, and what of them still holds.
///
/// A ray that ended on a plain surface ends there still if the elements around its end are what they were, and if it meets
/// nothing new on its way there. So rows of the same rays are taken over ray by ray. Rays that met specular
/// surfaces are traced again; so are those that met black backs, unless it is known where what is gone was.
#ifndef RSV_KEPT_ROWS_H
#define RSV_KEPT_ROWS_H

#include "row_catalogue.h"
#include "row_reader.h"
#include "scene_change.h"

typedef struct rsv_kept_rows {
    rsv_context *context;
    rsv_row_reader reader;
    uint32_t *row_before;   ///< [node_count] node then whose row has the same rays; RSV_NONE = none
    uint32_t *end_now;      ///< [node_count then] the same node now; RSV_NONE = there is none
    rsv_vec3 (*end_box)[2]; ///< [node_count] low and high of the cells around it
    rsv_scene_change added, change; ///< what is new; that, and what is gone where that is known
    double seconds;                 ///< that tracing all rows took then
} rsv_kept_rows;

/// Looks among the rows in a store for those most like the rows to be traced. @param now of these
/// @param earlier out: NULL if there are none
rsv_status rsv_kept_rows_open(const rsv_row_basis *basis, const rsv_row_catalogue *now,
    rsv_store *store, rsv_kept_rows **earlier);
void rsv_kept_rows_close(rsv_kept_rows *earlier);

/// What the rays of a row found then. @param earlier NULL = nothing is known @return false if nothing is known
bool rsv_kept_rows_find(const rsv_kept_rows *earlier, uint32_t node, rsv_kept_row *row);

#endif
