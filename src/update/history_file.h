/// The blob of a history (history.h): a header followed by arrays.
#ifndef RSV_HISTORY_FILE_H
#define RSV_HISTORY_FILE_H

#include "history.h"

#define RSV_HISTORY_MAGIC 0x37747370u // "pst7"

typedef struct rsv_history_header {
    uint64_t magic;
    uint64_t settings, lights; ///< keys
    uint64_t triangle_count;
    uint64_t faces[RSV_HISTORY_LEVELS], slots[RSV_HISTORY_LEVELS];
    uint64_t nodes[RSV_HISTORY_LEVELS]; ///< slots of the tables, powers of 2
    float spacing[2];                   ///< metres and reach of it
    uint64_t checksum;                  ///< of all, with 0 here
} rsv_history_header;

/// A triangle that lets no ray pass, in the order of the scene.
typedef struct rsv_history_triangle {
    uint64_t key;
    rsv_vec3 low, high;
} rsv_history_triangle;

/// A side of a triangle that has elements, in their order: the same one on all levels.
typedef struct rsv_history_face {
    uint64_t key;
    uint32_t slot;           ///< the first of its grid
    uint8_t level, halvings; ///< of the grid; of clusters
    uint8_t unused[2];
} rsv_history_face;

/// Cells of a level, as elements have them.
typedef struct rsv_history_cells {
    size_t face_count, slot_count;
    rsv_history_face *face; ///< [face_count]
    uint32_t *slot;         ///< [slot_count] RSV_SLOT_SPLIT and the first child, or anything
    uint8_t *openness;      ///< [slot_count] with RSV_OPENNESS_KNOWN; 0 = it is not
} rsv_history_cells;

/// A hash table with open addresses in a file. Key 0 = free slot.
typedef struct rsv_history_table {
    size_t slots;
    uint64_t *key;  ///< [slots]
    uint8_t *value; ///< [slots * value_bytes]
    size_t value_bytes;
} rsv_history_table;

#define RSV_HISTORY_NO_LIGHTS 0 ///< key of sources that are never what they were

typedef struct rsv_history_layout {
    rsv_history_triangle *triangle;
    rsv_history_cells cells[RSV_HISTORY_LEVELS];
    rsv_history_table nodes[RSV_HISTORY_LEVELS];
    size_t bytes;
} rsv_history_layout;

/// @param header of a blob as a whole
rsv_history_layout rsv_history_layout_of(const rsv_history_header *header);

/// The slot of a key, or the free one that it belongs to; any where a damaged table is full.
RSV_INLINE size_t rsv_history_slot(const rsv_history_table *table, uint64_t key)
{
    size_t at = key & (table->slots - 1);
    for (size_t k = 0; k < table->slots && table->key[at] && table->key[at] != key; k++)
        at = (at + 1) & (table->slots - 1);
    return at;
}

/// @return NULL if there is none
RSV_INLINE const uint8_t *rsv_history_find(const rsv_history_table *table, uint64_t key)
{
    if (table->slots == 0 || key == 0) return NULL;
    size_t at = rsv_history_slot(table, key);
    return table->key[at] == key ? table->value + at * table->value_bytes : NULL;
}

uint64_t rsv_history_checksum(const rsv_history_header *header, size_t bytes);

/// "<settings>.history"
void rsv_history_name(uint64_t settings, char name[RSV_STORE_NAME_BYTES]);

/// Key of all sources; RSV_HISTORY_NO_LIGHTS if textures affect their emission.
uint64_t rsv_history_lights_key(const rsv_lights *lights);
void rsv_history_triangle_box(
    const rsv_scene_view *scene, uint32_t triangle, rsv_vec3 *low, rsv_vec3 *high);

#endif
