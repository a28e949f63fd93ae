#include "surface_points.h"

#include "../elements/open_corners.h"

/// Whether something separates the point from a corner of its cell: then the point may be within it.
static bool is_obstructed(
    const rsv_transport_scene *scene, uint8_t openness, const rsv_cell_shape *shape, rsv_vec3 home)
{
    for (int k = 0; k < 3; k++) {
        rsv_vec3 corner = rsv_cell_inset(shape, shape->corner[k]);
        if (rsv_is_touched(scene->tracer, shape, corner) ||
            rsv_is_blocked(scene, home, rsv_cell_above(openness, shape, corner)))
            return true;
    }
    return false;
}

bool rsv_point_is_buried(const rsv_transport_scene *scene, const rsv_elements *e,
    const rsv_face_point *point, uint32_t seed, uint64_t *rays)
{
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, point->face, point->u, point->v, weight);
    rsv_cell_shape shape = rsv_cell_shape_of(e, cell);
    rsv_vec3 place = rsv_surface_point_at(
        e->scene, e->face_triangle[point->face], point->u, point->v, e->face_back[point->face])
                         .position;
    uint8_t openness = rsv_cell_openness(scene, e, cell, &shape, rays);
    rsv_vec3 home = rsv_cell_above(openness, &shape, place);
    *rays += 7;
    if (rsv_is_touched(scene->tracer, &shape, place) ||
        rsv_is_buried(scene, home, shape.normal, seed, rays))
        return true;
    return is_obstructed(scene, openness, &shape, home) &&
           rsv_is_mostly_buried(scene, home, shape.normal, seed, rays);
}
