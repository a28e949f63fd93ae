/// Elements near objects that moved, divided again where surfaces touch now, as a solve of the present scene would,
/// including nodes on both sides of an object. Elements that did not change are recognised by position.
#ifndef RSV_DIVIDED_ELEMENTS_H
#define RSV_DIVIDED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// Input: the elements before. All of it is borrowed.
typedef struct rsv_elements_before {
    const rsv_elements *start;    ///< cells to split: `elements`, or those of before anything moved
    const rsv_elements *first;    ///< those of before anything moved
    const rsv_elements *elements; ///< as they are, brought to where all is now (moved_elements.h)
    const uint16_t *valid_points; ///< [node_count of `elements`]
    const rsv_scene_change *change; ///< boxes around everything that moved since they were divided
    const uint8_t *moved;           ///< [triangle_count] 1 = it moved
    float contact_size;             ///< of `first` (rsv_elements_contact_size)
    size_t most_nodes;              ///< no more splits beyond
    rsv_support_draw draw;
} rsv_elements_before;

/// Divided elements, and those among them that have not changed.
typedef struct rsv_divided_elements {
    rsv_elements *elements; ///< owned
    uint16_t *valid_points; ///< [node_count], owned, like the others
    uint32_t *
        node_before; ///< [node_count] node that received the same light in the same way; RSV_NONE = none did
    /// [node_count of before] node that replaces this one in all cells; RSV_NONE = cells changed
    uint32_t *node_now;
} rsv_divided_elements;

rsv_status rsv_elements_divide(const rsv_transport_scene *scene, const rsv_elements_before *before,
    rsv_divided_elements *divided, uint64_t *rays);

/// Frees everything that was not taken out.
void rsv_divided_elements_free(rsv_context *context, rsv_divided_elements *divided);

#endif
