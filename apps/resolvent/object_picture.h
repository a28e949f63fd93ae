/// Pictures of a solution with an object that moves (resolvent/mover.h).
#ifndef CLI_OBJECT_PICTURE_H
#define CLI_OBJECT_PICTURE_H

#include "resolvent/mover.h"
#include "resolvent/render.h"

/// Renders in mode operator, with as many samples as were asked for and with the body moved by `offset` metres.
rsv_status cli_render_object(const rsv_light *solution, const rsv_scene *body, rsv_vec3 offset,
    const rsv_render_desc *desc, rsv_image **image);

#endif
