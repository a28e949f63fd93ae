/// Accessors of a glTF document, checked and decoded.
#ifndef RSV_GLTF_ACCESSOR_H
#define RSV_GLTF_ACCESSOR_H

#include "gltf_document.h"

/// Zero-filled accessors need no bytes in the file, so that their count must be bounded otherwise.
#define RSV_GLTF_MAX_ZERO_FILLED (1 << 24)

/// Vectors as an accessor holds them.
typedef struct rsv_gltf_attribute {
    float *values; ///< [count * width]; to be freed
    size_t count;
    size_t width; ///< components of each
} rsv_gltf_attribute;

/// Vectors of two to four components: float, or (KHR_mesh_quantization) integers. Errors name the accessor and
/// the mesh `owner`.
rsv_status rsv_gltf_read_attribute(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, rsv_gltf_attribute *attribute);

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

/// Numbers of an animation.
typedef struct rsv_gltf_numbers {
    size_t width; ///< components each: 1, 3 or 4
    float *value; ///< [count * width]; to be freed
    size_t count;
} rsv_gltf_numbers;

/// Times or values of an animation: float or normalised integers, all finite. @param numbers `width` in, the rest out
rsv_status rsv_gltf_read_keys(rsv_context *context, const rsv_gltf_document *document, int accessor,
    const char *animation, rsv_gltf_numbers *numbers);

/// Indices as an accessor holds them.
typedef struct rsv_gltf_indices {
    uint32_t *index; ///< [count]; to be freed
    size_t count;
} rsv_gltf_indices;

/// Indices, each below `vertex_count`.
rsv_status rsv_gltf_read_indices(rsv_context *context, const rsv_gltf_document *document,
    int accessor, const char *owner, size_t vertex_count, rsv_gltf_indices *indices);

#endif
