/// From which directions the entries of a row come: what makes maps of light by direction out of rows (directional.h).
///
/// Rays of a row go by bins of the hemisphere: its entries of weight 1 lie bin by bin, and per bin their number is kept.
/// Of those that a coat weighs, each remembers its bin.
#ifndef RSV_ROW_DIRECTIONS_H
#define RSV_ROW_DIRECTIONS_H

#include "../update/row_record.h"
#include "directions.h"
#include "division.h"

/// Of a tinted entry that counts no further ray.
#define RSV_NO_BIN UINT8_MAX

/// All rows of one receiver.
typedef struct rsv_row_direction {
    uint16_t tangent[2];              ///< of the frame of its bins, octahedral
    uint8_t set;                      ///< of directions
    uint8_t ends[RSV_DIRECTION_BINS]; ///< entries of weight 1
    uint8_t shut[RSV_DIRECTION_BINS /
                 2]; ///< rays that a coat left out, four bits each, in units of `shut_unit`
} rsv_row_direction;

typedef struct rsv_row_directions {
    size_t count;           ///< rows that have rays, in the order of their nodes
    rsv_row_direction *row; ///< [count]
    uint8_t *tinted_bin;    ///< [tinted entries] bin of each, or RSV_NO_BIN
    uint16_t *rays;         ///< [RSV_DIRECTION_SETS * RSV_DIRECTION_BINS] rays of a set in each bin
    uint32_t shut_unit;     ///< rays
} rsv_row_directions;

/// Room for the rows of nodes with valid points, and for `most` tinted entries.
rsv_status rsv_row_directions_create(
    rsv_context *context, size_t count, size_t most, rsv_row_directions **directions);
void rsv_row_directions_destroy(rsv_context *context, rsv_row_directions *directions);

/// Counts the rays of each set by bin.
void rsv_row_directions_begin(const rsv_directions *table, rsv_row_directions *directions);

/// Notes a row that was traced. @param first of the directions of its set
void rsv_row_directions_note(const rsv_directions *table, size_t first, const rsv_row_scratch *s,
    uint32_t shut_unit, rsv_row_direction *row);

/// Tangent of the frame in which bins are: about a normal, as close as it can be to that of the row.
rsv_vec3 rsv_row_direction_tangent(const rsv_row_direction *row);

/// Rays of a bin that a row has light of.
RSV_INLINE uint32_t rsv_row_direction_rays(
    const rsv_row_directions *directions, const rsv_row_direction *row, uint32_t bin)
{
    uint32_t all = directions->rays[row->set * RSV_DIRECTION_BINS + bin];
    uint32_t shut = (row->shut[bin / 2] >> 4 * (bin & 1) & 15u) * directions->shut_unit;
    return shut < all ? all - shut : 0;
}

#endif
