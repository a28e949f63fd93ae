/// Rows of G in serialised form, so that they need not be traced again.
#ifndef RSV_ROW_RECORD_H
#define RSV_ROW_RECORD_H

#include "../elements/elements.h"
#include "../specular/escapes.h"
#include "scene_change.h"

struct rsv_row_track; // operator/row_track.h

/// Results of the rays of one row.
typedef struct rsv_row_scratch {
    uint32_t *column; ///< [rays] RSV_NONE = nothing
    uint8_t *kind;    ///< [rays] kind of the first hit, below RSV_ROW_RAY_ENDS
    uint8_t *copies;  ///< [rays] how often an end counts, if `whole`
    bool whole;       ///< a colourless coat takes and gives whole ends
    uint32_t index;   ///< of the node whose random numbers were used
    uint16_t valid;   ///< points that were used, bit by bit
    uint32_t tinted_count;
    uint32_t *tinted_column; ///< [rays]
    rsv_rgb *tinted_weight;
    rsv_escape_row escapes;
    rsv_rgb emission;
    rsv_rgb flights;  ///< sum of the weights of flights through fog
    uint64_t rays;    ///< of all rows so far
    uint64_t kept;    ///< rays of all rows so far that rsv_row_retrace did not trace again
    size_t kept_rows; ///< rows so far of which it traced none
    struct rsv_row_track *track; ///< additional data of each ray; NULL = none
} rsv_row_scratch;

#define RSV_ROW_RAY_ENDS 0x80 ///< with the kind: the ray ended at a node

/// Results of the same rays before the edit.
typedef struct rsv_kept_row {
    uint32_t index;                 ///< of the node whose random numbers were used
    uint16_t valid;                 ///< points that were used
    const uint8_t *kind;            ///< [rays] with RSV_ROW_RAY_ENDS
    const uint32_t *column;         ///< nodes of then at which rays ended, in their order
    const uint32_t *end_now;        ///< the same nodes now; RSV_NONE = gone
    const rsv_vec3 (*end_box)[2];   ///< low and high of the cells around the nodes now
    const rsv_scene_change *added;  ///< boxes around new objects
    const rsv_scene_change *change; ///< these, and boxes around removed objects if known
} rsv_kept_row;

/// Records on their way to where they are kept.
typedef struct rsv_row_block {
    uint8_t *byte;
    size_t count, capacity;
} rsv_row_block;

/// Appends a row to a block. @param ray_count of each row @param rays that it took, specular paths included
rsv_status rsv_row_record_put(rsv_context *context, uint32_t node, uint32_t ray_count,
    const rsv_row_scratch *scratch, uint64_t rays, rsv_row_block *block);

/// @param bytes [left], at a multiple of 8
/// @param node out: whose row it is
/// @return bytes up to the next one; 0 if here is none that is whole and of such rows
size_t rsv_row_record_bytes(
    const uint8_t *bytes, size_t left, size_t node_count, uint32_t ray_count, uint32_t *node);

/// Whether a record is unharmed. @param count its bytes
bool rsv_row_record_is_sound(const uint8_t *bytes, size_t count, size_t node_count);

/// Fills `scratch` as tracing the row did. @param record one that was checked
void rsv_row_record_take(const uint8_t *record, uint32_t ray_count, rsv_row_scratch *scratch);

/// Results of each of its rays. @param record a checked one
rsv_kept_row rsv_row_record_kept(const uint8_t *record);

#endif
