/// Measured luminaires of EXT_lights_ies.
#ifndef RSV_GLTF_LUMINAIRE_H
#define RSV_GLTF_LUMINAIRE_H

#include "gltf_document.h"

/// Reads a luminaire of a document. RSV_ERROR_FORMAT if it does not exist or cannot be read.
/// @param luminaire to be freed by rsv_luminaire_free, even after a failure
rsv_status rsv_gltf_read_luminaire(
    rsv_context *context, const rsv_gltf_document *document, int index, rsv_luminaire *luminaire);

/// The light that a node has, without its place. False where its transform makes its direction zero.
/// @param world of the node
bool rsv_gltf_luminaire_light(const rsv_gltf_node *node, const double world[16],
    const rsv_luminaire *luminaire, rsv_punctual_light *light);

#endif
