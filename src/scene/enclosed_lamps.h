/// Lamps that nobody sees anything of, because something opaque is closed around them.
#ifndef RSV_ENCLOSED_LAMPS_H
#define RSV_ENCLOSED_LAMPS_H

#include "twin_tree.h"

/// Warns of point lights, spot lights and emissive objects within a closed opaque body, as a light bulb is modelled whose
/// glass got an opaque material. Rooms are no such bodies: cameras are in them, or a good part of what there is.
/// @param tree of all of the scene's triangles
void rsv_warn_of_enclosed_lamps(const rsv_scene *scene, const rsv_twin_tree *tree);

#endif
