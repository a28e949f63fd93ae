/// Simple bodies for the built-in scenes, each added as one mesh and one instance.
#ifndef RSV_SHAPES_H
#define RSV_SHAPES_H

#include "../core/vec.h"
#include "../scene/scene.h"

/// Position and material of a shape; `transform` NULL = identity.
typedef struct rsv_shape {
    rsv_scene *scene;
    const char *name;
    uint32_t material;
    const float *transform;
} rsv_shape;

/// Two triangles; the front is where the corners appear counter-clockwise.
rsv_status rsv_add_quad(rsv_shape shape, const rsv_vec3 corner[4]);

/// An upright block with a four-cornered footprint (x, z), counter-clockwise seen from above, without
/// its bottom face.
rsv_status rsv_add_block(rsv_shape shape, const float footprint[4][2], float bottom, float top);

/// A closed box that faces outwards.
rsv_status rsv_add_box(rsv_shape shape, rsv_vec3 low, rsv_vec3 high);

/// A closed box that faces inwards: a room.
rsv_status rsv_add_room(rsv_shape shape, rsv_vec3 low, rsv_vec3 high);

/// A geodesic sphere with smooth normals: 20 * 4^level triangles.
rsv_status rsv_add_sphere(rsv_shape shape, rsv_vec3 centre, float radius, int level);

#endif
