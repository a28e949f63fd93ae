/// A hierarchy of boxes around triangles, for finding triangles in the same place.
#ifndef RSV_TWIN_TREE_H
#define RSV_TWIN_TREE_H

#include "../core/core.h"
#include "twins.h"

#define RSV_TWIN_LEAF 4 ///< triangles of a leaf at most

/// Nodes as twins.h has them, for their owner.
typedef struct rsv_twin_tree {
    rsv_context *context;
    rsv_twin_node *node; ///< [node_count + 1]
    uint32_t *face;      ///< [face_count]
    uint32_t node_count, face_count;
} rsv_twin_tree;

/// Builds the tree in O(n log n), for any triangles.
/// @param face [face_count] indices of triangles of the scene; copied
/// @param flags [triangle_count], or NULL. Of exact copies with the same material and winding, only the last is added,
/// and gets
///              the flag RSV_TWIN_LAST; the others get RSV_TWIN_COPY
/// @param tree out
rsv_status rsv_twin_tree_create(rsv_context *context, const rsv_scene_view *scene,
    const uint32_t *face, uint32_t face_count, uint8_t *flags, rsv_twin_tree *tree);

/// Fits the boxes to where the triangles are now.
void rsv_twin_tree_fit(const rsv_scene_view *scene, rsv_twin_tree *tree);

void rsv_twin_tree_destroy(rsv_twin_tree *tree);

#endif
