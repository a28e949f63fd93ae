/// Skins of a glTF file: vertices follow the joints that they are bound to; the node that shows the mesh does not
/// count.
#ifndef RSV_GLTF_SKIN_H
#define RSV_GLTF_SKIN_H

#include "gltf_geometry.h"
#include "gltf_part.h"

/// The transforms that the joints of a skin apply to vertices.
typedef struct rsv_gltf_joints {
    rsv_context *context;
    const char *name;
    double (*matrix)
        [16]; ///< [count] bound vertex to world less `origin`, column-major; NULL = not made yet
    size_t count;
    double origin[3]; ///< in the world, near the vertices, so that floats keep their precision
} rsv_gltf_joints;

rsv_status rsv_gltf_joints_create(
    const rsv_gltf_parts *parts, size_t skin, rsv_gltf_joints *joints);
void rsv_gltf_joints_destroy(rsv_gltf_joints *joints);

/// Moves the vertices of a primitive to where its joints want them, relative to their origin. Weights are taken by
/// their shares; a vertex without any follows its first joint. @param mirrored whether its winding is turned
rsv_status rsv_gltf_bend(const rsv_gltf_joints *joints, const rsv_gltf_document *document,
    const rsv_gltf_primitive *primitive, const char *owner, bool mirrored,
    rsv_gltf_geometry *geometry);

/// Whether the first joint of a skin mirrors, which decides for all. RSV_ERROR_FORMAT for joints that do not exist.
rsv_status rsv_gltf_skin_mirrors(const rsv_gltf_parts *parts, size_t skin, bool *mirrored);

#endif
