/// Boxes for scenes that benchmarks build.
#ifndef CLI_BOX_MESH_H
#define CLI_BOX_MESH_H

#include "resolvent/scene.h"

/// Which way the faces of a box look: into a room, or out of a body.
typedef enum cli_facing { CLI_FACES_INWARDS, CLI_FACES_OUTWARDS } cli_facing;

/// Adds a box between two corners to a scene.
rsv_status cli_add_box(rsv_scene *scene, const char *name, rsv_vec3 low, rsv_vec3 high,
    cli_facing facing, uint32_t material);

#endif
