/// Drawing from a discrete distribution in constant time (Walker 1977, built as Vose 1991); drawing is for device code,
/// too.
#ifndef RSV_ALIAS_TABLE_H
#define RSV_ALIAS_TABLE_H

#include "core.h"
#include "vec.h"

typedef struct rsv_alias_entry {
    float keep;     ///< probability to stay where the number fell
    uint32_t other; ///< where to go else
} rsv_alias_entry;

/// @param weight [count], not negative; entries are equally likely if the sum is 0
/// @param table [count] out
/// @return RSV_OK or RSV_ERROR_MEMORY
rsv_status rsv_alias_table_fill(
    rsv_context *context, const double *weight, size_t count, rsv_alias_entry *table);

/// @param u in [0, 1)
RSV_INLINE uint32_t rsv_alias_table_draw(const rsv_alias_entry *table, uint32_t count, double u)
{
    double place = u * count;
    uint32_t k = (uint32_t)place < count ? (uint32_t)place : count - 1;
    return place - k < table[k].keep ? k : table[k].other;
}

#endif
