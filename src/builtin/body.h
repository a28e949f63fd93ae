/// The body in the middle of a built-in scene: a given one, or one of our own.
#ifndef RSV_BODY_H
#define RSV_BODY_H

#include "sculpture.h"

typedef struct rsv_body {
    const char *name;
    const rsv_scene *given; ///< committed; NULL = the stand-in
    rsv_sculpture stand_in;
    size_t triangles; ///< of the stand-in, about
    uint32_t material;
    rsv_vec3 foot; ///< where the middle of its bounding box's bottom comes to lie
    rsv_vec3 size; ///< of the box it is scaled to fit into
} rsv_body;

/// Adds the body as one mesh of one material that faces outwards.
rsv_status rsv_add_body(rsv_scene *scene, const rsv_body *body);

#endif
