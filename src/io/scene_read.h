/// The readers behind rsv_scene_load(): each fills an empty scene and leaves it uncommitted. Error
/// messages do not name the file.
#ifndef RSV_SCENE_READ_H
#define RSV_SCENE_READ_H

#include "gltf_document.h"
#include "resolvent/io.h"

typedef enum rsv_file_kind {
    RSV_FILE_UNKNOWN,
    RSV_FILE_GLTF,
    RSV_FILE_OBJ,
    RSV_FILE_PLY,
    RSV_FILE_FBX,
    RSV_FILE_COLLADA,
    RSV_FILE_STL
} rsv_file_kind;

/// Pipes and devices are refused: a reader could wait on one for ever.
rsv_status rsv_find_file_kind(
    const rsv_file_source *source, const char *path, rsv_file_kind *kind);

/// Puts the file's name in front of the error message. @return `status`
rsv_status rsv_name_file(rsv_status status, const char *path);

/// Sides as the caller wants them, before commit. Bodies that let light through have an inside, and stay as they are.
void rsv_set_sides(const rsv_load_desc *desc, rsv_scene *scene);

/// Fills a scene with a document's contents. @param is_moment the scene has its materials already: messages are not
/// repeated
rsv_status rsv_gltf_fill(
    const rsv_gltf_document *document, const rsv_load_desc *desc, bool is_moment, rsv_scene *scene);

/// glTF 2.0.
rsv_status rsv_gltf_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene);

/// Stanford polygons, text and binary.
rsv_status rsv_ply_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene);

/// STL, text and binary.
rsv_status rsv_stl_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene);

/// All other kinds.
rsv_status rsv_assimp_read(
    const char *path, rsv_file_kind kind, const rsv_load_desc *desc, rsv_scene *scene);

#endif
