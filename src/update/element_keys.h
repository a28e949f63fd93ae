/// Keys of nodes and cells: by them they are known again on the elements of another version of the scene.
///
/// They say where things are, and nothing of materials.
#ifndef RSV_ELEMENT_KEYS_H
#define RSV_ELEMENT_KEYS_H

#include "../elements/elements.h"

uint64_t rsv_triangle_key(const rsv_scene_view *scene, uint32_t triangle);

/// Of a triangle with its normals, and the side.
uint64_t rsv_face_key_of(const rsv_scene_view *scene, uint32_t triangle, uint8_t back);
uint64_t rsv_face_key(const rsv_elements *elements, uint32_t face);
/// Of a cell by its place on the face; it may be one that was split.
uint64_t rsv_cell_key_on(uint64_t face_key, const rsv_cell *cell);

/// Key of each cell: of its triangle with its normals, the side, and the place there.
/// @param key [cell_count], out
void rsv_elements_cell_keys(const rsv_elements *elements, uint64_t *key);

/// Key of each node: of all cells whose light it receives, those of its followers included.
/// @param cell_key [cell_count] @param key [node_count], out
void rsv_elements_node_keys(const rsv_elements *elements, const uint64_t *cell_key, uint64_t *key);

/// Keys of all nodes. @param key out: [node_count], freed by the caller
rsv_status rsv_node_keys_create(const rsv_elements *elements, uint64_t **key);

#endif
