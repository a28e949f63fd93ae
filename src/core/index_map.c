#include "index_map.h"

#include <string.h>

static size_t slot_of(const rsv_index_map *map, uint64_t key)
{
    // the finaliser of splitmix64: neighbouring keys land far apart
    uint64_t h = key;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    size_t slot = (size_t)(h ^ (h >> 31)) & (map->capacity - 1);
    while (map->value[slot] != UINT32_MAX && map->key[slot] != key)
        slot = (slot + 1) & (map->capacity - 1);
    return slot;
}

static rsv_status allocate(rsv_index_map *map, size_t capacity)
{
    map->key = rsv_reserve(map->context, capacity, sizeof *map->key);
    map->value = rsv_reserve(map->context, capacity, sizeof *map->value);
    if (!map->key || !map->value) return RSV_ERROR_MEMORY;
    memset(map->value, 0xff, capacity * sizeof *map->value);
    map->capacity = capacity;
    return RSV_OK;
}

rsv_status rsv_index_map_create(rsv_context *context, size_t expected, rsv_index_map *map)
{
    *map = (rsv_index_map){ .context = context };
    size_t capacity = 64;
    while (capacity < 2 * expected)
        capacity *= 2;
    rsv_status status = allocate(map, capacity);
    if (status != RSV_OK) rsv_index_map_destroy(map);
    return status;
}

void rsv_index_map_destroy(rsv_index_map *map)
{
    if (!map->context) return;
    rsv_free(map->context, map->key);
    rsv_free(map->context, map->value);
    *map = (rsv_index_map){ 0 };
}

static rsv_status grow(rsv_index_map *map)
{
    rsv_index_map larger = { .context = map->context, .count = map->count };
    rsv_status status = allocate(&larger, 2 * map->capacity);
    if (status != RSV_OK) {
        rsv_index_map_destroy(&larger);
        return status;
    }
    for (size_t i = 0; i < map->capacity; i++) {
        if (map->value[i] == UINT32_MAX) continue;
        size_t slot = slot_of(&larger, map->key[i]);
        larger.key[slot] = map->key[i];
        larger.value[slot] = map->value[i];
    }
    rsv_index_map_destroy(map);
    *map = larger;
    return RSV_OK;
}

uint32_t rsv_index_map_find(const rsv_index_map *map, uint64_t key)
{
    return map->value[slot_of(map, key)];
}

uint32_t rsv_index_map_insert(rsv_index_map *map, uint64_t key, uint32_t fresh)
{
    if (2 * (map->count + 1) > map->capacity && grow(map) != RSV_OK) return UINT32_MAX;
    size_t slot = slot_of(map, key);
    if (map->value[slot] == UINT32_MAX) {
        map->key[slot] = key;
        map->value[slot] = fresh;
        map->count++;
    }
    return map->value[slot];
}
