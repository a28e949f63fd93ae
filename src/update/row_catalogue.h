/// Keys of the elements of stored rows, by which their nodes are recognised on the elements of an edited scene.
#ifndef RSV_ROW_CATALOGUE_H
#define RSV_ROW_CATALOGUE_H

#include "../elements/elements.h"
#include "../specular/specular_walk.h"
#include "store.h"

/// Input of tracing rows; borrowed.
typedef struct rsv_row_basis {
    const rsv_transport_scene *scene;
    const rsv_elements *elements;
    const uint16_t *valid_points; ///< [node_count] from rsv_find_buried
    const uint8_t *side_kind; ///< [2 * triangle_count] how rays treat each side of each triangle
    uint32_t ray_count, seed;
} rsv_row_basis;

typedef struct rsv_row_catalogue_header {
    uint32_t magic, ray_count, seed, unused;
    uint64_t node_count, cell_count, triangle_count;
    double seconds;    ///< that tracing all rows takes
    uint64_t checksum; ///< of all, with 0 here
} rsv_row_catalogue_header;

/// Arrays lie one after the other behind the header.
typedef struct rsv_row_catalogue {
    rsv_context *context;
    rsv_row_catalogue_header *header;
    uint64_t *node_key;       ///< [node_count]
    uint64_t *cell_key;       ///< [cell_count] of the cell and how rays treat it
    uint64_t *triangle_key;   ///< [triangle_count] rsv_scene_change_keys
    uint32_t (*cell_node)[3]; ///< [cell_count]
    uint8_t *has_row;         ///< [node_count]
} rsv_row_catalogue;

rsv_status rsv_row_catalogue_create(const rsv_row_basis *basis, rsv_row_catalogue **catalogue);

/// @param catalogue out: NULL where the blob is none, or not whole
rsv_status rsv_row_catalogue_read(
    rsv_context *context, rsv_store *store, const char *name, rsv_row_catalogue **catalogue);

/// A warning where that fails.
void rsv_row_catalogue_write(rsv_row_catalogue *catalogue, rsv_store *store, const char *name);

void rsv_row_catalogue_destroy(rsv_row_catalogue *catalogue);

#endif
