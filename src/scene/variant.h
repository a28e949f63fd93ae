/// A committed scene under other lights, colours and surroundings, and with parts of it elsewhere, beside the scene itself:
/// what does not differ is the scene's own.
#ifndef RSV_VARIANT_H
#define RSV_VARIANT_H

#include "resolvent/scene.h"

/// A copy of materials and punctual lights, and of what else `base`, if it is a variant itself, has of its own; everything
/// else is borrowed.
/// @param base committed
/// @param variant to be freed by rsv_scene_destroy, before `base`
rsv_status rsv_scene_vary(const rsv_scene *base, rsv_scene **variant);

/// Gives a variant vertices of its own, that can be moved. Does nothing where it has them. Views that were asked for
/// earlier stay valid and see the new places.
rsv_status rsv_scene_vary_positions(rsv_scene *variant);

/// The same for the normals and tangents of vertices.
rsv_status rsv_scene_vary_normals(rsv_scene *variant);

/// Gives a variant pixels of surroundings of its own, that can be changed. Does nothing where it has them, or there are none.
rsv_status rsv_scene_vary_environment(rsv_scene *variant);

#endif
