/// The readers behind rsv_scene_load(): each fills an empty scene and leaves it uncommitted. Error
/// messages do not name the file.
#ifndef RSV_SCENE_READ_H
#define RSV_SCENE_READ_H

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
