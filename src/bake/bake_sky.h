/// The surroundings that a scene was baked under, as a picture for backgrounds and reflections.
#ifndef RSV_BAKE_SKY_H
#define RSV_BAKE_SKY_H

#include "../solve/light.h"

/// RSV_ERROR_ARGUMENT where there are no surroundings.
rsv_status rsv_bake_check_sky(const rsv_light_view *light);

/// Writes OUT.hdr, not rotated. @param output as of the bake
rsv_status rsv_bake_write_sky(const rsv_light_view *light, const char *output);

#endif
