/// What maps of light by direction consist of.
#ifndef RSV_DIRECTIONAL_INTERNAL_H
#define RSV_DIRECTIONAL_INTERNAL_H

#include "directional.h"
#include "directional_map.h"

/// Numbers of receivers among 64 nodes.
typedef struct rsv_receiver_word {
    uint64_t bits;         ///< nodes that are receivers
    uint64_t below;        ///< receivers among the nodes before
    uint64_t tinted_below; ///< their tinted entries
} rsv_receiver_word;

typedef struct rsv_look_up_kernels rsv_look_up_kernels;

struct rsv_directional {
    rsv_context *context;
    const rsv_elements *elements;
    const rsv_transport *transport;
    const rsv_row_directions *rows;
    const rsv_look_up_kernels *kernels;
    rsv_receiver_word *word;  ///< [node_count / 64 + 1]
    rsv_directional_map *map; ///< [rows->count]
    size_t tinted_count;      ///< tinted entries of all rows
    rsv_cell4 *exitance; ///< [node_count + 1] of the light that the maps are of; the last is black
    float
        share[RSV_DIRECTION_BINS]; ///< of the cells in the projected solid angle of the hemisphere
};

#endif
