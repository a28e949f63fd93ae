/// Textures and materials of a glTF document, put into a scene.
#ifndef RSV_GLTF_TEXTURE_H
#define RSV_GLTF_TEXTURE_H

#include "gltf_document.h"
#include "texture_image.h"

/// Finds the bytes of an image or luminaire. @return NULL = found, or what is wrong
const char *rsv_gltf_find_bytes(
    const rsv_gltf_document *document, const rsv_gltf_image *image, rsv_image_file *file);

/// Adds all materials, in order, with the textures they use. If a texture cannot be read, a warning names it and the
/// material uses its factor alone.
rsv_status rsv_gltf_add_materials(
    rsv_context *context, const rsv_gltf_document *document, rsv_scene *scene);

#endif
