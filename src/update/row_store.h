/// Stores rows of G as they are traced, so that interrupted runs can continue, and runs after an edit can reuse them.
///
/// A store belongs to one scene and one version of the program. The names of its blobs encode everything else that rows
/// depend on: elements, buried points, rays, seed. Every process of a team appends to its own blob and reads those of
/// all, so a run may continue with another number of processes. A record that was cut off when its writer ended is
/// dropped. Once all rows are there, a catalogue describes their elements (row_catalogue.h).
#ifndef RSV_ROW_STORE_H
#define RSV_ROW_STORE_H

#include "row_catalogue.h"
#include "row_record.h"

typedef struct rsv_row_store rsv_row_store;

/// @param basis of the rows; borrowed for the call @param store out
rsv_status rsv_row_store_open(const rsv_row_basis *basis, rsv_row_store **store);
void rsv_row_store_close(rsv_row_store *store);

/// Fills `scratch` as tracing the row did, if it is known. @param store NULL = nothing is
bool rsv_row_store_take(const rsv_row_store *store, uint32_t node, rsv_row_scratch *scratch);

/// Results of the row's rays before the edit, if known.
bool rsv_row_store_find_kept(const rsv_row_store *store, uint32_t node, rsv_kept_row *row);

/// Adds a row just traced to a block. @param rays that it took
rsv_status rsv_row_store_keep(rsv_row_store *store, uint32_t node, const rsv_row_scratch *scratch,
    uint64_t rays, rsv_row_block *block);

/// Appends a block to the blob and empties it; threads may call it at the same time. After a failure, such as a full
/// disk, all calls fail: rows before it are kept.
rsv_status rsv_row_store_write(rsv_row_store *store, rsv_row_block *block);
/// @return why writing failed, if it did, with the message for the calling thread
rsv_status rsv_row_store_outcome(const rsv_row_store *store);

/// All rows are there. @param seconds that this took
/// @return seconds that rows of an earlier version of the scene spared, about
double rsv_row_store_finish(rsv_row_store *store, double seconds);

#endif
