/// A variant of a committed scene, with other lights, colours, environment or positions. It shares everything else with
/// the original scene.
#ifndef RSV_VARIANT_H
#define RSV_VARIANT_H

#include "resolvent/scene.h"

/// Creates a variant with copies of materials and punctual lights, and of whatever else `base` does not share if it is
/// a variant itself. Everything else is borrowed.
/// @param base committed
/// @param variant free it with rsv_scene_destroy, before `base`
rsv_status rsv_scene_vary(const rsv_scene *base, rsv_scene **variant);

/// Gives a variant its own vertices, which can then be moved, unless it already has them. Existing views remain valid
/// and show the new positions.
rsv_status rsv_scene_vary_positions(rsv_scene *variant);

/// The same for the normals and tangents of vertices.
rsv_status rsv_scene_vary_normals(rsv_scene *variant);

/// Gives a variant pixels of surroundings of its own, that can be changed. Does nothing where it has them, or there are
/// none.
rsv_status rsv_scene_vary_environment(rsv_scene *variant);

#endif
