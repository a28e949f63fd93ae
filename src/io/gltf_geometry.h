/// The vertices and triangles of a glTF primitive, with its morph targets added.
#ifndef RSV_GLTF_GEOMETRY_H
#define RSV_GLTF_GEOMETRY_H

#include "gltf_document.h"

typedef struct rsv_gltf_geometry {
    rsv_vec3 *position, *normal;    ///< [vertex_count]
    float *uv[2], *tangent, *color; ///< [vertex_count] of 2, 4 and 4 floats
    uint32_t *index;                ///< [index_count]; NULL = 0, 1, 2, ...
    size_t vertex_count, index_count;
} rsv_gltf_geometry;

/// Weights of morph targets; those that are missing are 0.
typedef struct rsv_gltf_weights {
    const float *value; ///< [count]
    size_t count;
} rsv_gltf_weights;

/// Those of a node, else those of its mesh.
rsv_gltf_weights rsv_gltf_weights_of(const rsv_gltf_document *document, const rsv_gltf_node *node);

/// Reads a primitive that has positions. Strips and fans become separate triangles. Errors name the mesh `owner`.
/// The caller releases `*geometry`, after failures too.
rsv_status rsv_gltf_read_geometry(rsv_context *context, const rsv_gltf_document *document,
    const rsv_gltf_primitive *primitive, rsv_gltf_weights weights, const char *owner,
    rsv_gltf_geometry *geometry);

void rsv_gltf_release_geometry(rsv_context *context, rsv_gltf_geometry *geometry);

#endif
