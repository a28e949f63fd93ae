/// A glTF file as plain arrays. Only the parser behind rsv_gltf_open() is C++; what reads a document is
/// C. References are unchecked numbers from the file: -1 = none, anything else may be out of range.
#ifndef RSV_GLTF_DOCUMENT_H
#define RSV_GLTF_DOCUMENT_H

#include "resolvent/io.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_gltf_component {
    RSV_GLTF_BYTE = 5120,
    RSV_GLTF_UNSIGNED_BYTE = 5121,
    RSV_GLTF_SHORT = 5122,
    RSV_GLTF_UNSIGNED_SHORT = 5123,
    RSV_GLTF_UNSIGNED_INT = 5125,
    RSV_GLTF_FLOAT = 5126
} rsv_gltf_component;

/// Bytes of a component; 0 = there is no such type.
static inline size_t rsv_gltf_component_bytes(int type)
{
    switch (type) {
    case RSV_GLTF_BYTE:
    case RSV_GLTF_UNSIGNED_BYTE:
        return 1;
    case RSV_GLTF_SHORT:
    case RSV_GLTF_UNSIGNED_SHORT:
        return 2;
    case RSV_GLTF_UNSIGNED_INT:
    case RSV_GLTF_FLOAT:
        return 4;
    default:
        return 0;
    }
}

typedef enum rsv_gltf_mode {
    RSV_GLTF_TRIANGLES = 4,
    RSV_GLTF_TRIANGLE_STRIP = 5,
    RSV_GLTF_TRIANGLE_FAN = 6
} rsv_gltf_mode;

typedef struct rsv_gltf_buffer {
    const uint8_t *data;
    size_t size;
    const char *uri; ///< of the file or data; NULL = the binary chunk, or nothing of the file
} rsv_gltf_buffer;

typedef struct rsv_gltf_buffer_view {
    int buffer;
    size_t offset, length;
    size_t stride; ///< 0 = tightly packed
} rsv_gltf_buffer_view;

/// Where a run of elements lies.
typedef struct rsv_gltf_span {
    int buffer_view;
    size_t offset;
    int component_type; ///< rsv_gltf_component, if the file is right
} rsv_gltf_span;

typedef struct rsv_gltf_accessor {
    rsv_gltf_span span; ///< buffer_view -1 = all zero
    size_t count;
    int component_count; ///< 1 for scalars, 3 for vectors, ...
    bool normalized;
    size_t sparse_count; ///< elements replaced by the spans below
    rsv_gltf_span sparse_indices, sparse_values;
} rsv_gltf_accessor;

/// A morph target: the accessors of the offsets that it adds to each attribute.
typedef struct rsv_gltf_target {
    int position, normal, tangent, uv[2], color;
} rsv_gltf_target;

/// Four joints per vertex and their weights: accessors.
typedef struct rsv_gltf_influence {
    int joints, weights;
} rsv_gltf_influence;

/// The material of a primitive in a variant.
typedef struct rsv_gltf_variant {
    int variant, material;
} rsv_gltf_variant;

typedef struct rsv_gltf_primitive {
    int position, normal, indices; ///< accessors
    int uv[2], tangent, color;     ///< accessors
    int material;
    int mode;
    const rsv_gltf_target *target;       ///< [target_count] morph targets
    const rsv_gltf_influence *influence; ///< [influence_count]
    size_t target_count, influence_count;
    const rsv_gltf_variant *variant; ///< [variant_count]
    size_t variant_count;
} rsv_gltf_primitive;

typedef struct rsv_gltf_mesh {
    const char *name;
    const rsv_gltf_primitive *primitive;
    size_t primitive_count;
    const float *weight; ///< [weight_count] of its morph targets; those missing are 0
    size_t weight_count;
} rsv_gltf_mesh;

typedef struct rsv_gltf_skin {
    const char *name;
    const int *joint; ///< [joint_count] nodes
    size_t joint_count;
    int inverse_bind_matrices; ///< accessor; -1 = all identity
} rsv_gltf_skin;

/// EXT_mesh_gpu_instancing: accessors; all -1 = the mesh is shown once.
typedef struct rsv_gltf_instancing {
    int translation, rotation, scale;
} rsv_gltf_instancing;

typedef struct rsv_gltf_node {
    const char *name;
    int mesh, camera, light, skin;
    int luminaire;           ///< of EXT_lights_ies; -1 = none
    rsv_rgb luminaire_scale; ///< its multiplier times its colour
    rsv_vec3 opening;        ///< of it, m (extras.opening, which this library writes)
    const int *child;
    size_t child_count;
    double local[16];                             ///< column-major, to the parent
    double translation[3], rotation[4], scale[3]; ///< parts of `local` without a matrix
    bool has_matrix;
    const float *weight; ///< [weight_count] in place of those of the mesh; NULL = those
    size_t weight_count;
    bool hidden; ///< by KHR_node_visibility, with all below
    bool instanced;
    rsv_gltf_instancing instancing;
} rsv_gltf_node;

typedef struct rsv_gltf_light {
    rsv_punctual_light value; ///< kind, intensity, cone and name; placed by nodes
    double strength;          ///< the number `intensity`, without the colour
    bool known;               ///< false = of a kind that is not in the format: left out
} rsv_gltf_light;

/// The property of a node that an animation channel moves.
typedef enum rsv_gltf_path {
    RSV_GLTF_TRANSLATION,
    RSV_GLTF_ROTATION,
    RSV_GLTF_SCALE,
    RSV_GLTF_WEIGHTS,
    RSV_GLTF_OTHER_PATH ///< by an extension, or not in the format
} rsv_gltf_path;

typedef enum rsv_gltf_interpolation {
    RSV_GLTF_LINEAR,
    RSV_GLTF_STEP,
    RSV_GLTF_CUBIC_SPLINE,
    RSV_GLTF_OTHER_INTERPOLATION ///< not in the format
} rsv_gltf_interpolation;

typedef struct rsv_gltf_channel {
    int sampler; ///< of the animation
    int node;    ///< -1 = none: ignore the channel
    rsv_gltf_path path;
} rsv_gltf_channel;

typedef struct rsv_gltf_sampler {
    int input, output; ///< accessors
    rsv_gltf_interpolation interpolation;
} rsv_gltf_sampler;

typedef struct rsv_gltf_animation {
    const char *name;
    const rsv_gltf_channel *channel; ///< [channel_count]
    const rsv_gltf_sampler *sampler; ///< [sampler_count]
    size_t channel_count, sampler_count;
} rsv_gltf_animation;

/// A message about the whole file.
typedef struct rsv_gltf_note {
    rsv_log_level level;
    const char *text;
} rsv_gltf_note;

/// An encoded picture, or a measured luminaire as a file of LM-63.
typedef struct rsv_gltf_image {
    const char *name;     ///< its own or its file's
    const uint8_t *bytes; ///< NULL = in `buffer_view`, or missing
    size_t size;
    int buffer_view;
    const char *uri; ///< of the file or data; NULL = none
} rsv_gltf_image;

typedef struct rsv_gltf_texture {
    int image;
    int ktx; ///< image of KHR_texture_basisu, preferred to `image` if it can be read; < 0 = none
    rsv_wrap wrap_u, wrap_v;
    bool nearest;
} rsv_gltf_texture;

/// Use of a texture by a material; `ref.texture` is set once the texture is in the scene.
typedef struct rsv_gltf_texture_ref {
    int texture;
    bool srgb;
    rsv_texture_ref ref;
} rsv_gltf_texture_ref;

typedef struct rsv_gltf_material {
    rsv_material value; ///< without textures
    const rsv_gltf_texture_ref *texture;
    size_t texture_count;
    const char *note;   ///< what is approximated or ignored; "" = nothing
    const char *remark; ///< what is left out without any effect on the result; "" = nothing
    bool opaque;        ///< alpha is ignored, wherever it comes from
} rsv_gltf_material;

typedef struct rsv_gltf_document {
    const rsv_gltf_buffer *buffer;
    const rsv_gltf_buffer_view *buffer_view;
    const rsv_gltf_accessor *accessor;
    const rsv_gltf_mesh *mesh;
    const rsv_gltf_node *node;
    const rsv_gltf_material *material;
    const rsv_gltf_texture *texture;
    const rsv_gltf_image *image;
    const rsv_camera *camera; ///< lens and name; placed by nodes
    const rsv_gltf_light *light;
    const rsv_gltf_image *luminaire; ///< of EXT_lights_ies
    const rsv_gltf_skin *skin;
    const rsv_gltf_animation *animation;
    const int *root;           ///< nodes of the scene to show
    const rsv_gltf_note *note; ///< parts of the file that are not read
    size_t buffer_count, buffer_view_count, accessor_count, mesh_count, node_count, material_count,
        camera_count, light_count, skin_count, animation_count, root_count, texture_count,
        image_count, note_count, luminaire_count;
    const char *text; ///< [text_bytes] the JSON as it stands in the file
    size_t text_bytes;
    const char *const *variant; ///< [variant_count] names (KHR_materials_variants)
    size_t variant_count;
    const char *generator; ///< the program that wrote the file, in its own words; "" = it says none
} rsv_gltf_document;

/// Parses a .gltf or .glb file and reads its buffers, which must lie in the file's folder or below. Bytes beyond a
/// buffer's byteLength are left out; buffers that say nowhere where they are have no data. Images are read as they are,
/// not decoded; missing ones have neither bytes nor a buffer view. Error messages do not name the file.
rsv_status rsv_gltf_open(
    const rsv_file_source *files, const char *path, const rsv_gltf_document **document);
/// The same from an archive in memory (gltf_archive.h): no file is read.
/// @param archive [count]; borrowed until this returns
rsv_status rsv_gltf_open_archive(
    const uint8_t *archive, size_t count, const rsv_gltf_document **document);
void rsv_gltf_close(const rsv_gltf_document *document);

#ifdef __cplusplus
}
#endif

#endif
