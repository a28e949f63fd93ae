/// Lamps enclosed by something opaque, whose light cannot be seen.
#ifndef RSV_ENCLOSED_LAMPS_H
#define RSV_ENCLOSED_LAMPS_H

#include "twin_tree.h"

/// Warns of point lights, spot lights and emissive objects inside a closed opaque body, such as a light bulb with an
/// opaque glass material. Rooms do not count as bodies: they contain cameras, or a good part of the scene.
/// @param tree of all triangles of the scene
void rsv_warn_of_enclosed_lamps(const rsv_scene *scene, const rsv_twin_tree *tree);

#endif
