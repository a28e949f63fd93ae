/// Measured luminaires among a scene's punctual lights.
#ifndef RSV_PLACED_LUMINAIRE_H
#define RSV_PLACED_LUMINAIRE_H

#include "resolvent/scene.h"

/// RSV_ERROR_FORMAT where a light of kind RSV_PUNCTUAL_LUMINAIRE names no luminaire of the scene or stands in no usable
/// way.
rsv_status rsv_check_placed_luminaire(
    const rsv_scene *scene, const rsv_punctual_light *light, const char *name);

/// Whether a name is meant by one with `*` and `?`.
bool rsv_name_is_meant(const char *pattern, const char *name);

#endif
