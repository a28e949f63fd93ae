#include "first_map.h"

#include "key.h"
#include "parallel.h"

static void clear_slots(void *user, rsv_span span)
{
    const rsv_first_map *map = user;
    for (size_t k = span.begin; k < span.end; k++) {
        atomic_init(&map->slot[k].key, 0);
        atomic_init(&map->slot[k].first, UINT32_MAX);
    }
}

rsv_status rsv_first_map_create(rsv_context *context, size_t most, rsv_first_map *map)
{
    *map = (rsv_first_map){ .context = context, .capacity = 64 };
    while (3 * map->capacity < 4 * most + 4) // a quarter stays free
        map->capacity *= 2;
    map->slot = rsv_reserve(context, map->capacity, sizeof *map->slot);
    if (!map->slot) return RSV_ERROR_MEMORY;
    rsv_parallel_for(context, map->capacity, 0, clear_slots, map);
    return RSV_OK;
}

void rsv_first_map_destroy(rsv_first_map *map)
{
    if (map->context) rsv_free(map->context, map->slot);
    *map = (rsv_first_map){ 0 };
}

static size_t home_of(const rsv_first_map *map, uint64_t key)
{
    return (size_t)rsv_key_add(0, key) & (map->capacity - 1);
}

uint32_t rsv_first_map_note(rsv_first_map *map, uint64_t key, uint32_t place)
{
    size_t at = home_of(map, key);
    for (;; at = (at + 1) & (map->capacity - 1)) {
        uint64_t there = atomic_load_explicit(&map->slot[at].key, memory_order_relaxed);
        if (there == 0 && atomic_compare_exchange_strong_explicit(&map->slot[at].key, &there, key,
                              memory_order_relaxed, memory_order_relaxed))
            break;
        if (there == key) break;
    }
    rsv_lower(&map->slot[at].first, place);
    return (uint32_t)at;
}

uint32_t rsv_first_map_find(const rsv_first_map *map, uint64_t key)
{
    size_t at = home_of(map, key);
    for (;; at = (at + 1) & (map->capacity - 1)) {
        uint64_t there = atomic_load_explicit(&map->slot[at].key, memory_order_relaxed);
        if (there == key) return (uint32_t)at;
        if (there == 0) return UINT32_MAX;
    }
}
