/// Primitives of the file being baked, each with a JSON object of its own.
#ifndef RSV_BAKE_PRIMITIVE_H
#define RSV_BAKE_PRIMITIVE_H

#include "bake_tessellate.h"

/// Gives every node that shows light a mesh of its own, as its light is its own.
/// @param primitive out, [parts->count] JSON of each part; freed by the caller
rsv_status rsv_bake_separate(
    rsv_bake_document *document, const rsv_bake_parts *parts, cJSON ***primitive);

/// Whether a primitive's vertices may be divided: it is not skinned or morphed, and all its attributes are known.
bool rsv_bake_may_divide(const cJSON *primitive);

/// The colours that a primitive's vertices have, at those of the mesh. @param color out; NULL = none @param width 3 or
/// 4
rsv_status rsv_bake_read_colors(const rsv_bake_document *document, const cJSON *primitive,
    const rsv_bake_part *part, const rsv_bake_mesh *mesh, float **color, size_t *width);

/// Replaces vertices and indices by those of a mesh: attributes in the middle of edges are means.
rsv_status rsv_bake_replace_vertices(rsv_bake_document *document, cJSON *primitive,
    const rsv_bake_part *part, const rsv_bake_mesh *mesh);

/// Material of a primitive; NULL = the default one.
cJSON *rsv_bake_material(const rsv_bake_document *document, const cJSON *primitive);

#endif
