/// Visibility of places just above cells.
#ifndef RSV_CELL_VISIBILITY_H
#define RSV_CELL_VISIBILITY_H

#include "../specular/specular_path.h"
#include "elements.h"

/// A cell in space.
typedef struct rsv_cell_shape {
    rsv_vec3 corner[3], centre;
    rsv_vec3 normal; ///< unit, geometric
    float size;      ///< edge of a right triangle of its area
    float spacing;   ///< of the elements that it is one of
    float extent;    ///< for rsv_offset_origin
} rsv_cell_shape;

rsv_cell_shape rsv_cell_shape_of(const rsv_elements *elements, uint32_t cell);

/// A place on the border of a cell, moved slightly towards its centre, away from objects that only touch the border.
rsv_vec3 rsv_cell_inset(const rsv_cell_shape *shape, rsv_vec3 border);

/// Right above a place by a tenth of the elements' spacing (of the cell's size, if that is larger): higher than gaps
/// that light could pass below a wall.
rsv_vec3 rsv_cell_above_gaps(const rsv_cell_shape *shape, rsv_vec3 place);

/// The same below anything that does not touch the place.
rsv_vec3 rsv_cell_within_gap(const rsv_cell_shape *shape, rsv_vec3 place);

/// Whether something touches the cell at a place: anything less than a fiftieth of the elements' spacing above, however
/// small the cell.
bool rsv_is_touched(const rsv_tracer *tracer, const rsv_cell_shape *shape, rsv_vec3 place);

/// Whether something lies right upon the cell at a place: anything that touches it, something opaque less than a fifth
/// of the elements' spacing (or of the cell's size, if that is larger) above, a lamp less than a fifth of the cell's
/// size, or less than half of it and nearly all there is to see.
bool rsv_is_covered(const rsv_transport_scene *scene, const rsv_cell_shape *shape, rsv_vec3 place);

/// How far one can see from a place towards another before anything opaque, as a part of the way; 1 = all of it.
float rsv_clear_part(const rsv_transport_scene *scene, rsv_vec3 from, rsv_vec3 to);

/// Whether anything opaque stands between two places.
RSV_INLINE bool rsv_is_blocked(const rsv_transport_scene *scene, rsv_vec3 from, rsv_vec3 to)
{
    return rsv_clear_part(scene, from, to) < 1;
}

/// Whether a surface is the skin of an opaque body: its back is inside.
RSV_INLINE bool rsv_bounds_body(const rsv_bsdf *bsdf)
{
    return !bsdf->double_sided && bsdf->transmission == 0 && bsdf->opacity == 1;
}

/// Whether a place sees nothing but the backs of one-sided opaque surfaces: it lies inside something.
/// @param seed of the few directions that are tried
bool rsv_is_buried(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal, uint32_t seed,
    uint64_t *rays);

/// The same for a place close to other geometry, whose view may be inside that geometry too: a floor and a rear wall
/// that both continue into a wall see each other there. More expensive, and decided by a majority.
bool rsv_is_mostly_buried(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal,
    uint32_t seed, uint64_t *rays);

/// Whether a place itself (not one that hovers above a cell) is inside a closed opaque body: all rays from it see that
/// body's skin from inside, past other bodies in it or after reflections. Does not depend on elements.
bool rsv_is_within_body(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal,
    uint32_t seed, uint64_t *rays);

/// Whether rays that arrive at a place of a triangle see another face there (scene/twins.h), so that its light is
/// hidden.
/// @param normal of the side at which they arrive
bool rsv_is_behind_twin(const rsv_scene_view *scene, rsv_hit place, rsv_vec3 normal);

/// Geometry closer than this above a surface touches it, metres. The same for solutions of every quality.
float rsv_touch_distance(const rsv_transport_scene *scene);

/// Whether something touches a place of a triangle, or another face in the same place hides it.
/// @param at the same place @param touch rsv_touch_distance
bool rsv_is_touched_or_hidden(const rsv_transport_scene *scene, rsv_hit place,
    const rsv_surface_point *at, float touch, uint64_t *rays);

#endif
