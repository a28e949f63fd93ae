/// Parts of a glTF file that get light: a primitive of a mesh, once for every node that shows it.
#ifndef RSV_BAKE_PART_H
#define RSV_BAKE_PART_H

#include "../io/gltf_part.h"
#include "../solve/light.h"
#include "bake_document.h"

typedef struct rsv_bake_part {
    uint32_t node, mesh, primitive; ///< of the file
    uint32_t copy;     ///< of EXT_mesh_gpu_instancing, in `shown`; RSV_NONE = the node itself
    uint32_t instance; ///< of the scene
    bool mirrored;     ///< its winding is turned
    char label[160];   ///< for messages
    // of the primitive, in its own space
    rsv_vec3 *position; ///< [vertex_count]
    size_t vertex_count;
    uint32_t (*corner)[3]; ///< [triangle_count]
    size_t triangle_count;
    uint32_t *triangle; ///< [triangle_count] of the scene; RSV_NONE = of no area
    uint8_t *back;      ///< [triangle_count] whether it shows the light of its back (bake_side.h)
} rsv_bake_part;

typedef struct rsv_bake_parts {
    rsv_context *context;
    rsv_bake_part *part; ///< [count], as in `shown`
    size_t count;
    rsv_gltf_parts shown; ///< visible parts when the file is loaded
} rsv_bake_parts;

/// Lists the parts in the order of the scene's instances. RSV_ERROR_ARGUMENT if the scene was not loaded from
/// this file, RSV_ERROR_SCENE if no part carries light.
rsv_status rsv_bake_parts_create(
    const rsv_bake_document *document, const rsv_light_view *solution, rsv_bake_parts *parts);
void rsv_bake_parts_destroy(rsv_bake_parts *parts);

/// Whether a part has a diffuse lobe, whose base colour multiplies light.
bool rsv_bake_carries_light(const rsv_light_view *solution, const rsv_bake_part *part);

/// The scene's barycentric coordinates for weights of the corners of the file's triangle.
static inline void rsv_bake_place(
    const rsv_bake_part *part, float weight1, float weight2, float *u, float *v)
{
    *u = part->mirrored ? weight2 : weight1;
    *v = part->mirrored ? weight1 : weight2;
}

#endif
