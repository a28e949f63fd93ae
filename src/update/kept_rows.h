/// Rows from before an edit, as far as they are still valid.
///
/// A ray that ended on a plain surface still ends there if the elements around its end have not changed, and if it
/// meets nothing new on the way. Rows with the same rays are therefore reused ray by ray. Rays that met specular
/// surfaces are traced again. So are those that met black backs, unless the positions of removed objects are known.
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
    rsv_scene_change added, change; ///< new objects; new and, if known, removed objects
    double seconds;                 ///< that tracing all rows took then
} rsv_kept_rows;

/// Finds the rows in a store that are most similar to the rows to be traced. @param now of these
/// @param earlier out: NULL if there are none
rsv_status rsv_kept_rows_open(const rsv_row_basis *basis, const rsv_row_catalogue *now,
    rsv_store *store, rsv_kept_rows **earlier);
void rsv_kept_rows_close(rsv_kept_rows *earlier);

/// Stored results of a row's rays. @param earlier NULL = none @return false if there are none
bool rsv_kept_rows_find(const rsv_kept_rows *earlier, uint32_t node, rsv_kept_row *row);

#endif
