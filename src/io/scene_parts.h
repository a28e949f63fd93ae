/// Parts of a scene on their way from one process to another: a stream of records, sent in the order in which they are
/// to be added. Meshes and materials count from 0.
#ifndef RSV_SCENE_PARTS_H
#define RSV_SCENE_PARTS_H

#include "resolvent/io.h"
#include "texture_image.h"

#include <stdio.h>

/// The caller looks at ferror(to) at the end.
void rsv_send_log(FILE *to, rsv_log_level level, const char *message);
#define RSV_PART_PATH_BYTES 1024

/// A texture to be sent.
typedef struct rsv_part_texture {
    const char *name;     ///< of its file, as the scene's file spells it
    const uint8_t *bytes; ///< [size] the contents of the file; NULL = read it from `name`
    size_t size;
    bool srgb, shines; ///< these and the following as in rsv_texture_source
    rsv_texture_use use;
    float shininess;
    rsv_wrap wrap_u, wrap_v;
} rsv_part_texture;

/// Textures count from 0.
void rsv_send_texture(FILE *to, const rsv_part_texture *texture);
/// Its textures are those sent before.
void rsv_send_material(FILE *to, const rsv_material *material);
/// Without tangents and colours.
void rsv_send_mesh(FILE *to, const rsv_mesh_desc *mesh);
void rsv_send_instance(FILE *to, uint32_t mesh, const double transform[16], const char *name);
void rsv_send_light(FILE *to, const rsv_punctual_light *light);
void rsv_send_camera(FILE *to, const rsv_camera *camera);

/// Adds all parts to an empty scene and repeats the messages that were logged. RSV_ERROR_FORMAT if the bytes are not a
/// whole number of records; otherwise errors of the scene. Textures that cannot be read are named in a warning and left
/// out.
/// @param bytes [count], aligned to 4 @param path the scene's file: textures are looked for beside it, in `files`
rsv_status rsv_receive_parts(const uint8_t *bytes, size_t count, const rsv_file_source *files,
    const char *path, rsv_scene *scene);

#endif
