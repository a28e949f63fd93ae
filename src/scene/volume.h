/// Densities of a scene's fog.
#ifndef RSV_SCENE_VOLUME_H
#define RSV_SCENE_VOLUME_H

#include "../core/core.h"
#include "resolvent/scene.h"

struct rsv_volume;

/// Extinction beyond which a micrometre is opaque, and products with lengths leave the range of float, 1/m.
#define RSV_LARGEST_EXTINCTION 1e6f

/// This one and all that came before it; NULL is allowed.
void rsv_volumes_destroy(rsv_context *context, struct rsv_volume *volume);

#endif
