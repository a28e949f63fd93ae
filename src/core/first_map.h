/// A hash table that all threads fill in parallel. It stores the smallest index for each key, whatever the order of
/// insertion.
#ifndef RSV_FIRST_MAP_H
#define RSV_FIRST_MAP_H

#include "core.h"
#include "vec.h"

#include <stdatomic.h>

typedef struct rsv_first_slot {
    _Atomic uint64_t key;   ///< 0 = free slot
    _Atomic uint32_t first; ///< the least place noted
} rsv_first_slot;

typedef struct rsv_first_map {
    rsv_context *context;
    rsv_first_slot *slot; ///< [capacity]
    size_t capacity;
} rsv_first_map;

/// @param most keys there may be; the table does not grow
rsv_status rsv_first_map_create(rsv_context *context, size_t most, rsv_first_map *map);
void rsv_first_map_destroy(rsv_first_map *map);

/// Notes that a key other than 0 occurs at a place. Any thread. @return its slot, which the order of calls decides on
uint32_t rsv_first_map_note(rsv_first_map *map, uint64_t key, uint32_t place);

/// The slot of a key, or UINT32_MAX. Any thread, after all have been noted.
uint32_t rsv_first_map_find(const rsv_first_map *map, uint64_t key);

/// Lowers a number to `place` unless it is lower already. Any thread.
RSV_INLINE void rsv_lower(_Atomic uint32_t *number, uint32_t place)
{
    uint32_t was = atomic_load_explicit(number, memory_order_relaxed);
    while (place < was && !atomic_compare_exchange_weak_explicit(
                              number, &was, place, memory_order_relaxed, memory_order_relaxed)) {}
}

#endif
