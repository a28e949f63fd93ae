/// Parts of a scene on their way from one process to another: a stream of records, sent in the order in which they are to
/// be added. Meshes and materials count from 0.
#ifndef RSV_SCENE_PARTS_H
#define RSV_SCENE_PARTS_H

#include "resolvent/scene.h"

#include <stdio.h>

/// The caller looks at ferror(to) at the end.
void rsv_send_log(FILE *to, rsv_log_level level, const char *message);
/// Without textures.
void rsv_send_material(FILE *to, const rsv_material *material);
/// Without texture coordinates, tangents and colours.
void rsv_send_mesh(FILE *to, const rsv_mesh_desc *mesh);
void rsv_send_instance(FILE *to, uint32_t mesh, const double transform[16], const char *name);
void rsv_send_light(FILE *to, const rsv_punctual_light *light);
void rsv_send_camera(FILE *to, const rsv_camera *camera);

/// Adds all parts to a scene that has none, and logs what was logged. RSV_ERROR_FORMAT if the bytes are no whole number of
/// records, or as the scene refuses them. @param bytes [count], aligned to 4
rsv_status rsv_receive_parts(const uint8_t *bytes, size_t count, rsv_scene *scene);

#endif
