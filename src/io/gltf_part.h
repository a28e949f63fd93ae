/// The visible parts of a glTF file: each primitive of triangles, once for each node and instance that shows it. The
/// list matches the instances of the scene one by one, so that a caller can read the file again alongside its scene.
#ifndef RSV_GLTF_PART_H
#define RSV_GLTF_PART_H

#include "gltf_document.h"

typedef struct rsv_gltf_part {
    uint32_t node, mesh, primitive; ///< of the file
    uint32_t copy; ///< of EXT_mesh_gpu_instancing, counted through the whole file; RSV_NONE = none
    bool skinned;  ///< placed by joints, not by its node
    bool mirrored; ///< its winding is turned
} rsv_gltf_part;

typedef struct rsv_gltf_parts {
    rsv_context *context;
    const rsv_gltf_document *document;
    double (*world)[16];       ///< [node_count] of all nodes that can be reached, column-major
    bool *placed;              ///< [node_count] whether there is such a matrix
    bool *hidden;              ///< [node_count] by KHR_node_visibility, itself or by a node above
    uint32_t *order;           ///< [order_count] nodes of the scene, parents first
    double (*copy)[16];        ///< [copy_count] instances, to their node
    uint32_t *first_copy;      ///< [node_count] of those
    signed char *skin_mirrors; ///< [skin_count] 0 = not known yet, else a sign
    double memory;             ///< bytes that this machine has
    double bytes;              ///< that the parts take at the least, once they are in a scene
    rsv_gltf_part *part;       ///< [count]
    size_t order_count, copy_count, count;
    size_t copy_capacity, capacity;
} rsv_gltf_parts;

/// Fails if the nodes form no forest, if a node, mesh or skin that is referred to does not exist, or if memory cannot
/// suffice.
rsv_status rsv_gltf_parts_create(
    rsv_context *context, const rsv_gltf_document *document, rsv_gltf_parts *parts);
void rsv_gltf_parts_destroy(rsv_gltf_parts *parts);

/// Where a part is that is not skinned: object to world.
void rsv_gltf_part_world(const rsv_gltf_parts *parts, const rsv_gltf_part *part, double world[16]);

#endif
