/// Rows of G kept in files while they are traced, so that a run that is killed need not trace them again, nor one of the
/// same scene after an edit all of them.
///
/// A folder belongs to one scene and one version of the program. In it, files are named after all else that rows depend
/// on: elements, buried points, rays, seed. Every process of a team appends to a file of its own and reads those of all,
/// so that a run may go on with another number of them. A record cut off by the end of its writer is dropped. Once all
/// rows are there, a catalogue says what they were traced on (row_catalogue.h).
#ifndef RSV_CHECKPOINT_H
#define RSV_CHECKPOINT_H

#include "row_record.h"

typedef struct rsv_checkpoint rsv_checkpoint;

/// @param tracer has begun @param checkpoint out: NULL if the scene asks for none
rsv_status rsv_checkpoint_open(const rsv_row_tracer *tracer, rsv_checkpoint **checkpoint);
void rsv_checkpoint_close(rsv_checkpoint *checkpoint);

/// Fills `scratch` as tracing the row did, if it is known. @param checkpoint NULL = nothing is
bool rsv_checkpoint_take(const rsv_checkpoint *checkpoint, uint32_t node, rsv_row_scratch *scratch);

/// What the rays of the row found before the scene was edited, if that is known.
bool rsv_checkpoint_recall(const rsv_checkpoint *checkpoint, uint32_t node, rsv_row_past *past);

/// Adds a row just traced to a block. @param rays that it took
rsv_status rsv_checkpoint_keep(rsv_checkpoint *checkpoint, uint32_t node,
    const rsv_row_scratch *scratch, uint64_t rays, rsv_row_block *block);

/// Appends a block to the file and empties it; threads may call it at the same time. After a failure, such as a full
/// disk, all calls fail: rows before it are kept.
rsv_status rsv_checkpoint_write(rsv_checkpoint *checkpoint, rsv_row_block *block);
/// @return why writing failed, if it did, with the message for the calling thread
rsv_status rsv_checkpoint_outcome(const rsv_checkpoint *checkpoint);

/// All rows are there. @param seconds that this took
/// @return seconds that rows of an earlier version of the scene spared, about
double rsv_checkpoint_finish(rsv_checkpoint *checkpoint, double seconds);

#endif
