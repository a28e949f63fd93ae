/// Elements beside which something moved, divided again where surfaces touch now: as a solve of the scene as it is would divide
/// them, nodes on both sides of what stands there included. What did not change is known again by its place.
#ifndef RSV_DIVIDED_ELEMENTS_H
#define RSV_DIVIDED_ELEMENTS_H

#include "../elements/burial.h"
#include "light_shafts.h"

/// What elements are divided again from; all of it is borrowed.
typedef struct rsv_elements_before {
    const rsv_elements *start;    ///< cells to split: `elements`, or those of before anything moved
    const rsv_elements *first;    ///< those of before anything moved
    const rsv_elements *elements; ///< as they are, brought to where all is now (moved_elements.h)
    const uint16_t *valid_points; ///< [node_count of `elements`] likewise
    const rsv_scene_change *change; ///< boxes around all that moved since they were divided
    const uint8_t *moved;           ///< [triangle_count] 1 = it moved
    float contact_size;             ///< of `first` (rsv_elements_contact_size)
    size_t most_nodes;              ///< no more splits beyond
    rsv_support_draw draw;
} rsv_elements_before;

/// Divided elements, and which of them are what they were.
typedef struct rsv_divided_elements {
    rsv_elements *elements; ///< to be destroyed
    uint16_t *valid_points; ///< [node_count] to be freed, as the others
    uint32_t *
        node_before; ///< [node_count] node that received the same light in the same way; RSV_NONE = none did
    /// [node_count of before] node that stands in all cells for what this one stood for; RSV_NONE = cells changed
    uint32_t *node_now;
} rsv_divided_elements;

rsv_status rsv_elements_divide(const rsv_transport_scene *scene, const rsv_elements_before *before,
    rsv_divided_elements *divided, uint64_t *rays);

/// Frees all of it but what was taken out.
void rsv_divided_elements_free(rsv_context *context, rsv_divided_elements *divided);

#endif
