/// The file that a scene was loaded from, with all files it refers to, for writing it again with additions. The scene
/// keeps it, but does not read it.
#ifndef RSV_DOCUMENT_H
#define RSV_DOCUMENT_H

#include "resolvent/scene.h"

typedef struct rsv_scene_document {
    char *name;     ///< of the file, for messages
    uint8_t *bytes; ///< [count] an archive (io/gltf_archive.h); NULL = none
    size_t count;
} rsv_scene_document;

/// Gives a scene its document, in place of the one that it has.
/// @param name copied @param bytes [count] of the scene's context; taken over, even on failure
rsv_status rsv_scene_set_document(rsv_scene *scene, const char *name, uint8_t *bytes, size_t count);

/// That of a scene, for variants too; NULL = none.
const rsv_scene_document *rsv_scene_find_document(const rsv_scene *scene);

#endif
