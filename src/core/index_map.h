/// A hash table from 64-bit keys to 32-bit indices, for numbering things by identity.
#ifndef RSV_INDEX_MAP_H
#define RSV_INDEX_MAP_H

#include "core.h"

typedef struct rsv_index_map {
    rsv_context *context;
    uint64_t *key;   ///< [capacity]
    uint32_t *value; ///< [capacity]; UINT32_MAX = free slot
    size_t capacity, count;
} rsv_index_map;

/// @param expected number of keys; the table grows beyond it
rsv_status rsv_index_map_create(rsv_context *context, size_t expected, rsv_index_map *map);
void rsv_index_map_destroy(rsv_index_map *map);

/// Index stored under `key`, or UINT32_MAX.
uint32_t rsv_index_map_find(const rsv_index_map *map, uint64_t key);

/// Index stored under `key`; stores `fresh` first if there is none. UINT32_MAX when out of memory.
uint32_t rsv_index_map_insert(rsv_index_map *map, uint64_t key, uint32_t fresh);

#endif
