/// Accessors of a glTF document, checked and decoded.
#ifndef RSV_GLTF_ACCESSOR_H
#define RSV_GLTF_ACCESSOR_H

#include "gltf_document.h"

/// Zero-filled accessors need no bytes in the file, so that their count must be bounded otherwise.
#define RSV_GLTF_MAX_ZERO_FILLED (1 << 24)

/// Vectors of two to four components: float, or (KHR_mesh_quantization) integers. Errors name the accessor and
/// the mesh `owner`. The caller frees `*values`, [count * component_count].
rsv_status rsv_gltf_read_attribute(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, float **values, size_t *count, size_t *component_count);

/// The same, of three components.
rsv_status rsv_gltf_read_vectors(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, rsv_vec3 **vectors, size_t *count);

/// One transform's part for each instance of a node: vectors of `width` components, as many as the accessor has
/// elements. The caller frees `*values`.
rsv_status rsv_gltf_read_instances(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *node, size_t width, float **values);

/// The inverse bind matrices of a skin, column-major. The caller frees `*matrices`, [count].
rsv_status rsv_gltf_read_matrices(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *skin, float (**matrices)[16], size_t *count);

/// Times or values of an animation: `width` components each, float or normalised integers, all finite. The caller frees
/// `*values`, [count * width].
rsv_status rsv_gltf_read_keys(rsv_context *context, const rsv_gltf_document *document, int accessor,
    const char *animation, size_t width, float **values, size_t *count);

/// Indices, each below `vertex_count`.
rsv_status rsv_gltf_read_indices(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, size_t vertex_count, uint32_t **indices, size_t *count);

#endif
